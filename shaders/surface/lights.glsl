// Direct light: of directional, point and spot lights, all of them discs or spheres of some size, and of surfaces; with shadows.
#include "surface/environment_light.glsl"
#include "surface/light_at.glsl"

layout(binding = 14) uniform sampler2DArrayShadow shadow_maps;
#if !FEATURE_ENVIRONMENT_VISIBILITY
layout(binding = 15) uniform sampler2DArray shadow_depths;  // the same texels, without comparison
#endif

// Karis 2013, "Real Shading in Unreal Engine 4": of the disc's points the one nearest to the mirror direction stands for all.
vec3 representative_direction(vec3 towards, float radius_rad, vec3 mirror) {
  float cosine = dot(towards, mirror);
  float edge = cos(radius_rad);
  if (cosine >= edge) return mirror;
  vec3 across = mirror - cosine * towards;
  float length2 = dot(across, across);
  return length2 > 0.0 ? edge * towards + sin(radius_rad) * inversesqrt(length2) * across : towards;
}

// By how much that point shines too bright for all: as a half vector sees it the disc has a radius of
//   rho = radius / (2 sqrt(VoH)),
// within which D is D(0), and beyond which it falls off as it would from the centre. For small angles u, where
// D(u) = a^2 / (pi (u^2 + a^2)^2), the integral of that over the plane is 1 + (pi / 2) (rho / a) + (rho / a)^2.
// A mirror then shows irradiance / (pi radius^2), the radiance of the disc.
float disc_gain(float alpha, float radius_rad, float VoH) {
  float q = 0.5 * radius_rad * inversesqrt(max(VoH, MIN_COSINE)) / alpha;
  return 1.0 + q * (0.5 * PI + q);
}

// What all lights share at a surface.
struct Lit {
  vec3 f0, f90;
  vec3 compensation;  // of the specular lobe
  vec3 albedo;        // of that lobe, all told
  BodyShares body;
};

Lit lit_surface(Surface s) {
  Lit lit;
  lit.f0 = mix(s.f0, s.metal_f0, s.metallic);
  lit.f90 = mix(s.f90, vec3(1.0), s.metallic);
#if FEATURE_PHONG
  lit.compensation = vec3(1.0);
  lit.body = body_shares(s, vec3(1.0 - s.metallic));
#elif FEATURE_SCHLICK_BECKMANN
  lit.compensation = vec3(1.0);
  lit.body = body_shares(s, (1.0 - s.metallic) * (1.0 - F_Schlick(s.NoV, s.f0, s.f90)));
#else
#if FEATURE_ANISOTROPY
  float alpha = sqrt(s.alpha * s.alpha_t);
#else
  float alpha = s.alpha;
#endif
  vec2 dfg = dfg_at(s.NoV, sqrt(alpha)).xy;
  lit.compensation = multiple_scattering(lit.f0, dfg);
  Reflectance r = reflectance(s, dfg);
  lit.albedo = r.specular;
  lit.body = body_shares(s, r.body);
#endif
  return lit;
}

// A specular lobe times n.l, without Fresnel's term, of a disc whose representative direction is `l`.
float specular_lobe(Surface s, vec3 normal, float NoV, float alpha, vec3 l, float radius_rad, float VoH, vec3 h) {
  float NoL = dot(normal, l);
  if (NoL <= 0.0) return 0.0;
  // A perfect mirror's lobe has no width of its own.
  float a = max(alpha, 1e-4);
  float NoH = clamp(dot(normal, h), 0.0, 1.0);
#if FEATURE_PHONG
  return (layers.is_phong != 0u ? phong_lobe(dot(reflect(-l, normal), s.to_viewer), a) : blinn_phong_lobe(NoH, a)) * NoL;
#elif FEATURE_SCHLICK_BECKMANN
  return D_GGX(NoH, a) / disc_gain(a, radius_rad, VoH) * V_SchlickBeckmann(NoV, NoL, sqrt(a)) * NoL;
#else
  return D_GGX(NoH, a) / disc_gain(a, radius_rad, VoH) * V_SmithGGXCorrelated(NoV, NoL, a) * NoL;
#endif
}

#if FEATURE_ANISOTROPY
float anisotropic_lobe(Surface s, vec3 l, float radius_rad, float VoH, vec3 h) {
  float NoL = dot(s.normal, l);
  if (NoL <= 0.0) return 0.0;
  vec3 b = cross(s.normal, s.tangent);
  // A perfect mirror's lobe has no width of its own.
  float alpha = max(s.alpha, 1e-4), alpha_t = max(s.alpha_t, 1e-4);
  float D = D_GGX_anisotropic(clamp(dot(s.normal, h), 0.0, 1.0), dot(s.tangent, h), dot(b, h), alpha_t, alpha);
  float V = V_SmithGGXAnisotropic(s.NoV, NoL, dot(s.tangent, s.to_viewer), dot(b, s.to_viewer), dot(s.tangent, l), dot(b, l),
                                  alpha_t, alpha);
  return D / disc_gain(sqrt(alpha * alpha_t), radius_rad, VoH) * V * NoL;
}
#endif

#if FEATURE_TRANSMISSION
// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", thin-walled as in KHR_materials_transmission: the
// lobe of a light behind the surface is that of its mirror image before it.
float transmitted_lobe(Surface s, vec3 towards, float radius_rad) {
  vec3 image = reflect(towards, s.normal);
  float a = max(s.transmitted_roughness * s.transmitted_roughness, 1e-3);
  vec3 l = representative_direction(image, radius_rad, reflect(-s.to_viewer, s.normal));
  vec3 h = normalize(l + s.to_viewer);
  float NoL = dot(s.normal, l);
  if (NoL <= 0.0) return 0.0;
  float VoH = clamp(dot(s.to_viewer, h), 0.0, 1.0);
  return D_GGX(clamp(dot(s.normal, h), 0.0, 1.0), a) / disc_gain(a, radius_rad, VoH) *
         V_SmithGGXCorrelated(s.NoV, NoL, a) * NoL;
}
#endif

// `towards`: unit, to the middle of a disc of angular radius `radius_rad`; `irradiance`: of a plane facing it.
void add_disc_light(Surface s, Lit lit, vec3 towards, float radius_rad, vec3 irradiance, inout Leaving light) {
  vec3 l = representative_direction(towards, radius_rad, reflect(-s.to_viewer, s.normal));
  vec3 h = normalize(l + s.to_viewer);
  float VoH = clamp(dot(s.to_viewer, h), 0.0, 1.0);
#if FEATURE_ANISOTROPY
  float lobe = anisotropic_lobe(s, l, radius_rad, VoH, h);
#else
  float lobe = specular_lobe(s, s.normal, s.NoV, s.alpha, l, radius_rad, VoH, h);
#endif
#if FEATURE_PHONG
  light.specular += irradiance * lobe * lit.f0;
#else
  light.specular += irradiance * lobe * F_Schlick(VoH, lit.f0, lit.f90) * lit.compensation;
#endif
  float cosine = dot(s.normal, towards);
  light.diffuse += irradiance * lit.body.reflected * (INV_PI * max(cosine, 0.0));
#if FEATURE_DIFFUSE_TRANSMISSION
  light.diffuse += irradiance * lit.body.scattered * (INV_PI * max(-cosine, 0.0));
#endif
#if FEATURE_TRANSMISSION
  if (cosine < 0.0)
    light.through += irradiance * lit.body.seen * exp(-layers.absorption.rgb * s.thickness_m) * transmitted_lobe(s, towards, radius_rad);
#endif
#if FEATURE_SHEEN
  if (cosine > 0.0) {
    vec3 half_way = normalize(towards + s.to_viewer);
    float alpha = s.sheen_roughness * s.sheen_roughness;
    float sheen = D_Charlie(clamp(dot(s.normal, half_way), 0.0, 1.0), alpha) * V_Charlie(s.NoV, cosine, alpha);
    light.sheen += irradiance * s.sheen_color * (sheen * cosine);
  }
#endif
#if FEATURE_CLEARCOAT
  vec3 coat_l = representative_direction(towards, radius_rad, reflect(-s.to_viewer, s.clearcoat_normal));
  vec3 coat_h = normalize(coat_l + s.to_viewer);
  float coat_VoH = clamp(dot(s.to_viewer, coat_h), 0.0, 1.0);
  light.clearcoat += irradiance * F_Schlick(coat_VoH, vec3(0.04), vec3(1.0)) *
                     specular_lobe(s, s.clearcoat_normal, s.clearcoat_NoV, s.clearcoat_alpha, coat_l, radius_rad, coat_VoH, coat_h);
#endif
}

#if FEATURE_SURFACE_LIGHTS && !(FEATURE_PHONG || FEATURE_SCHLICK_BECKMANN)
#include "surface/surface_lights.glsl"
#elif FEATURE_SURFACE_LIGHTS
// The older models see a disc as large.
void add_surface_light(Surface s, Lit lit, LightRow light, vec3 radiance, float distance_m, inout Leaving leaving) {
  vec3 towards = (light.place.xyz - s.position) / distance_m;
  float turned = light.place.w == LIGHT_BALL ? 1.0 : abs(dot(light.axis.xyz, towards));
  float radius_rad = atan(light.axis.w * sqrt(turned), distance_m);
  float sine = sin(radius_rad);
  add_disc_light(s, lit, towards, radius_rad, radiance * (PI * sine * sine), leaving);
}
#endif

// Which of the six views of a point light sees a direction from it: +X -X +Y -Y +Z -Z.
int cube_face(vec3 d) {
  vec3 a = abs(d);
  if (a.x >= a.y && a.x >= a.z) return d.x > 0.0 ? 0 : 1;
  if (a.y >= a.z) return d.y > 0.0 ? 2 : 3;
  return d.z > 0.0 ? 4 : 5;
}

// Vogel 1979, "A better way to construct the sunflower head": place i of n in the unit disc.
vec2 disc_place(int i, int n) {
  float angle = 2.39996323 * float(i);
  return sqrt((float(i) + 0.5) / float(n)) * vec2(cos(angle), sin(angle));
}

// Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare": interleaved gradient noise, [0, 1).
float pixel_noise() {
  vec2 at = floor(gl_FragCoord.xy) + vec2(lights.tile_x, lights.tile_y);
  return fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715))));
}

// How the depth in a view changes with its (u, v) over the plane through a point: exact, since depth is linear there. Isidoro 2006,
// "Shadow Mapping: GPU-based Tips and Techniques", so that a plane does not shadow itself however wide the filter is.
vec2 depth_slope(mat4 clip_from_world, vec4 clip, vec3 normal) {
  vec3 x = unit_across(normal);
  vec4 along_x = clip_from_world * vec4(x, 0.0), along_y = clip_from_world * vec4(cross(normal, x), 0.0);
  vec3 dx = (along_x.xyz - clip.xyz * (along_x.w / clip.w)) * vec3(0.5, -0.5, 1.0);
  vec3 dy = (along_y.xyz - clip.xyz * (along_y.w / clip.w)) * vec3(0.5, -0.5, 1.0);
  float area = dx.x * dy.y - dx.y * dy.x;
  // Seen edge-on it has no slope that would mean anything.
  if (abs(area) < 0.02 * length(dx.xy) * length(dy.xy)) return vec2(0.0);
  return vec2(dx.z * dy.y - dy.z * dx.y, dy.z * dx.x - dx.z * dy.x) / area;
}

// The share of a light that reaches a point, [0, 1]: Fernando 2005, "Percentage-Closer Soft Shadows". `normal`: of the surface, without
// a map.
float light_visibility(LightRow light, vec3 position, vec3 normal, vec3 to_light, float distance_m) {
  if (light.shadow.x < 0.0) return 1.0;
  // Off the surface by some texels, more where the light grazes it, so that it does not shadow itself.
  float texel_m = light.shadow.z * (light.place.w > LIGHT_FAR ? distance_m : 1.0);
  float cosine = clamp(dot(normal, to_light), -1.0, 1.0);
  vec3 lit_side = cosine < 0.0 ? -normal : normal;
  vec3 lifted = position + (lit_side * sqrt(1.0 - cosine * cosine) + to_light) * (2.0 * texel_m);
  int view = int(light.shadow.x) + (light.shadow.w > 1.0 ? cube_face(lifted - light.eye.xyz) : 0);
  vec4 clip = lights.shadow_from_world[view] * vec4(lifted, 1.0);
  vec3 at = clip.xyz / clip.w;
  vec2 uv = at.xy * vec2(0.5, -0.5) + 0.5;
  float texel = lights.shadow_texel;
  if (clip.w <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return 1.0;
  vec2 slope = depth_slope(lights.shadow_from_world[view], clip, normal);
  float radius = 1.5 * texel;
  mat2 turn = mat2(1.0);
  if (light.shadow.y > 0.0) {
    // Each pixel turns the places its own way: grain, where all alike would draw contours.
    float angle = TWO_PI * pixel_noise();
    turn = mat2(cos(angle), sin(angle), -sin(angle), cos(angle));
    const int kSearch = 8;
    float search = min(0.08, light.shadow.y * (light.place.w > LIGHT_FAR ? 4.0 * at.z : 1.0 - at.z));
    float sum = 0.0, blockers = 0.0;
    for (int i = 0; i < kSearch; ++i) {
      vec2 offset = turn * disc_place(i, kSearch) * search;
      float depth = textureLod(shadow_depths, vec3(uv + offset, view), 0.0).r;
      float blocks = depth > at.z + dot(slope, offset) ? 1.0 : 0.0;
      sum += blocks * depth;
      blockers += blocks;
    }
    if (blockers == 0.0) return 1.0;
    radius = clamp(light.shadow.y * (sum / blockers - at.z), radius, max(search, radius));
  }
  const int kTaps = 32;
  float lit = 0.0;
  for (int i = 0; i < kTaps; ++i) {
    vec2 offset = turn * disc_place(i, kTaps) * radius;
    lit += textureGrad(shadow_maps, vec4(uv + offset, view, at.z + dot(slope, offset)), vec2(0.0), vec2(0.0));
  }
  return lit / float(kTaps);
}

void add_direct_light(Surface s, inout Leaving leaving) {
  Lit lit = lit_surface(s);
  for (uint i = 0u; i < lights.count; ++i) {
    LightRow light = lights.lights[i];
#if FEATURE_SURFACE_LIGHTS
    if (light.place.w >= LIGHT_RECTANGLE) {
      vec3 to_light = light.place.xyz - s.position;
      float distance_m = max(length(to_light), 1e-6);
      to_light /= distance_m;
      if (!shines_towards(light, to_light)) continue;
      vec3 radiance = light.intensity.rgb * light_visibility(light, s.position, s.vertex_normal, to_light, distance_m);
      if (radiance != vec3(0.0)) add_surface_light(s, lit, light, radiance, distance_m, leaving);
      continue;
    }
#endif
    LightAt at = light_at(light, s.position);
    if (at.irradiance == vec3(0.0)) continue;
#if !(FEATURE_TRANSMISSION || FEATURE_DIFFUSE_TRANSMISSION || FEATURE_CLEARCOAT)
    // Nothing reaches a surface that is turned away, but for the edge of a disc.
    if (dot(s.normal, at.towards) < -sin(at.radius_rad)) continue;
#endif
    at.irradiance *= light_visibility(light, s.position, s.vertex_normal, at.towards, at.distance_m);
    if (at.irradiance == vec3(0.0)) continue;
    add_disc_light(s, lit, at.towards, at.radius_rad, at.irradiance, leaving);
  }
}
