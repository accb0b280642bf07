// Direct light of directional, point and spot lights, all of them discs or spheres of some size, with their shadows.
#include "interface/light_block.glsl"
#include "surface/environment_light.glsl"

layout(std140, binding = 4) uniform LightUniform { LightBlock lights; };
layout(binding = 14) uniform sampler2DArrayShadow shadow_maps;
layout(binding = 15) uniform sampler2DArray shadow_depths;  // the same texels, without comparison

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

// `towards`: unit, to the middle of a disc of angular radius `radius_rad`; `irradiance`: of a plane facing it.
vec3 disc_light(vec3 towards, float radius_rad, vec3 irradiance, vec3 f0, vec3 diffuse_albedo, vec2 dfg, float alpha,
                vec3 normal, vec3 to_viewer, float NoV) {
  vec3 mirror = reflect(-to_viewer, normal);
  vec3 l = representative_direction(towards, radius_rad, mirror);
  vec3 h = normalize(l + to_viewer);
  float NoL = dot(normal, l);
  float VoH = clamp(dot(to_viewer, h), 0.0, 1.0);
  vec3 specular = vec3(0.0);
  if (NoL > 0.0) {
    // A perfect mirror's lobe has no width of its own.
    float a = max(alpha, 1e-4);
    float D = D_GGX(clamp(dot(normal, h), 0.0, 1.0), a) / disc_gain(a, radius_rad, VoH);
    float e = dfg.x + dfg.y;
    vec3 compensation = 1.0 + f0 * ((1.0 - e) / max(e, MIN_COSINE));  // as specular_albedo()
    specular = D * V_SmithGGXCorrelated(NoV, NoL, a) * NoL * F_Schlick(VoH, f0) * compensation;
  }
  float cosine = max(dot(normal, towards), 0.0);
  return irradiance * (diffuse_albedo * (INV_PI * cosine) + specular);
}

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

// The share of a light that reaches a point, [0, 1]: Fernando 2005, "Percentage-Closer Soft Shadows".
float light_visibility(LightRow light, vec3 position, vec3 normal, vec3 to_light, float distance_m) {
  if (light.shadow.x < 0.0) return 1.0;
  // Off the surface by some texels, more where the light grazes it, so that it does not shadow itself.
  float texel_m = light.shadow.z * (light.place.w > 0.5 ? distance_m : 1.0);
  float cosine = clamp(dot(normal, to_light), 0.0, 1.0);
  vec3 lifted = position + (normal * sqrt(1.0 - cosine * cosine) + to_light) * (2.0 * texel_m);
  int view = int(light.shadow.x) + (light.shadow.w > 1.0 ? cube_face(lifted - light.eye.xyz) : 0);
  vec4 clip = lights.shadow_from_world[view] * vec4(lifted, 1.0);
  vec3 at = clip.xyz / clip.w;
  vec2 uv = at.xy * vec2(0.5, -0.5) + 0.5;
  float texel = lights.shadow_texel;
  if (clip.w <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return 1.0;
  float radius = 1.5 * texel;
  mat2 turn = mat2(1.0);
  if (light.shadow.y > 0.0) {
    // Each pixel turns the places its own way: grain, where all alike would draw contours.
    float angle = TWO_PI * pixel_noise();
    turn = mat2(cos(angle), sin(angle), -sin(angle), cos(angle));
    const int kSearch = 8;
    float search = min(0.08, light.shadow.y * (light.place.w > 0.5 ? 4.0 * at.z : 1.0 - at.z));
    float sum = 0.0, blockers = 0.0;
    for (int i = 0; i < kSearch; ++i) {
      float depth = textureLod(shadow_depths, vec3(uv + turn * disc_place(i, kSearch) * search, view), 0.0).r;
      float blocks = depth > at.z ? 1.0 : 0.0;
      sum += blocks * depth;
      blockers += blocks;
    }
    if (blockers == 0.0) return 1.0;
    radius = clamp(light.shadow.y * (sum / blockers - at.z), radius, max(search, radius));
  }
  const int kTaps = 32;
  float lit = 0.0;
  for (int i = 0; i < kTaps; ++i) {
    lit += textureGrad(shadow_maps, vec4(uv + turn * disc_place(i, kTaps) * radius, view, at.z), vec2(0.0), vec2(0.0));
  }
  return lit / float(kTaps);
}

vec3 direct_light(vec3 base_color, float metallic, float alpha, vec3 position, vec3 normal, vec3 to_viewer, float NoV) {
  vec2 dfg = textureLod(dfg_map, vec2(NoV, sqrt(alpha)), 0.0).xy;
  vec3 f0 = mix(vec3(0.04), base_color, metallic);
  vec3 diffuse_albedo = reflectance(base_color, metallic, dfg).diffuse;
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < lights.count; ++i) {
    LightRow light = lights.lights[i];
    vec3 to_light = light.place.xyz;
    float distance_m = 1.0, radius_rad = light.axis.w;
    vec3 irradiance = light.intensity.rgb;
    if (light.place.w > 0.5) {
      to_light -= position;
      distance_m = max(length(to_light), 1e-6);
      to_light /= distance_m;
      // KHR_lights_punctual: inverse square, a window at the range, the falloff of the cone. Within a sphere the light grows
      // no more.
      float reach2 = max(distance_m * distance_m, light.axis.w * light.axis.w);
      float q = reach2 * light.intensity.w;
      float cone = clamp(dot(light.axis.xyz, -to_light) * light.cone.x + light.cone.y, 0.0, 1.0);
      irradiance *= clamp(1.0 - q * q, 0.0, 1.0) * cone * cone / reach2;
      radius_rad = atan(light.axis.w, distance_m);
    }
    if (irradiance == vec3(0.0)) continue;
    vec3 light_sum = disc_light(to_light, radius_rad, irradiance, f0, diffuse_albedo, dfg, alpha, normal, to_viewer, NoV);
    if (light_sum == vec3(0.0)) continue;
    sum += light_sum * light_visibility(light, position, normal, to_light, distance_m);
  }
  return sum;
}
