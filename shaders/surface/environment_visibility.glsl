// The part of the environment's light that the scene keeps from itself: of directions that stand for the environment, those that
// see something else of the scene. Each sub-frame looks along some; what they find hidden is taken as a share of what all of all
// sub-frames shed on the lobe, a number that is known before, so that the mean over the sub-frames has no bias: it is the share
// that all directions together find. Where nothing is hidden the prefiltered light stays as it is.
#include "interface/sky_block.glsl"

layout(std140, binding = 6) uniform SkyUniform { SkyBlock sky; };
layout(binding = 13) uniform sampler2D sky_sums;  // of all directions: renderer/ibl/light_sums.hpp
layout(binding = 15) uniform sampler2DArray shadow_depths;

// 1 where something hides the direction from the surface, else 0.
float hidden_from(uint i, vec3 position, vec3 normal) {
  SkyView view = sky.views[i];
  vec3 l = view.towards.xyz;
  // Off the surface by some texels, more where the light grazes it, so that it does not shadow itself.
  float cosine = clamp(dot(normal, l), -1.0, 1.0);
  vec3 lit_side = cosine < 0.0 ? -normal : normal;
  vec4 lifted = vec4(position + (lit_side * sqrt(1.0 - cosine * cosine) + 0.5 * l) * view.towards.w, 1.0);
  // One texel: the maps of all directions lie differently over the surface, so that their mean has no steps.
  vec2 uv = vec2(dot(view.map_u, lifted), dot(view.map_v, lifted));
  float depth = texelFetch(shadow_depths, ivec3(ivec2(uv * sky.map_px), sky.first_layer + i), 0).r;
  return depth > dot(view.map_depth, lifted) ? 1.0 : 0.0;
}

// As in renderer/ibl/light_sums.hpp.
float ggx_lobe(float cosine, float alpha) {
  float a2 = alpha * alpha;
  float d = 0.5 * (1.0 - cosine) + a2 * 0.5 * (1.0 + cosine);
  return max(cosine, 0.0) * a2 * a2 / (d * d);
}

// Of map `index`, around unit `direction` (world).
vec3 sum_around(vec3 direction, int index) {
  vec2 texel = octahedral_from_direction(direction) * float(SKY_SUMS_PX - 1) + 0.5 + vec2(0.0, index * SKY_SUMS_PX);
  return textureLod(sky_sums, texel / vec2(SKY_SUMS_PX, SKY_SUMS_PX * (1 + SKY_LOBES)), 0.0).rgb;
}

// What all directions shed on a lobe around unit `direction`, its part below the horizon left out: in the plane, a lobe
// 1 / (1 + (u / s)^2)^2 has (1 + x / sqrt(x^2 + s^2)) / 2 beyond a line at a distance x. Here s is 2 alpha, x the elevation. The
// root of it is taken: half-way to all of the lobe, which no hidden light could exceed where it all lies above the horizon.
float lobe_sum(vec3 direction, float alpha, vec3 normal) {
  float at = clamp(1.0 - log(alpha) / log(sky.least_alpha), 0.0, 1.0) * float(SKY_LOBES - 1);
  int low = min(int(at), SKY_LOBES - 2);
  float sum = mix(sum_around(direction, 1 + low).r, sum_around(direction, 2 + low).r, at - float(low));
  float elevation = asin(clamp(dot(direction, normal), -1.0, 1.0));
  return sum * sqrt(0.5 + 0.5 * elevation * inversesqrt(elevation * elevation + 4.0 * alpha * alpha));
}

// A specular lobe of the environment's light.
struct SkyLobe {
  vec3 direction, normal;  // unit, world
  float alpha;             // no narrower than the directions lie apart
};

// Of a rough lobe some part lies so far off its middle that a round one has nothing there, and bright light counts there: that part is
// taken for one about the normal, and the rest leans less. Fitted to the shares of the true lobe that lie beyond planes through the
// surface; from alpha 0.25 on their error is half of a round lobe's.
float broad_share(float NoV, float alpha) {
  float m = 1.0 - NoV;
  float x = (2.0 + 4.0 * m * m * m) * alpha * alpha;
  return x / (1.0 + x);
}
float lean_of_rest(float NoV, float alpha) { return 0.75 - 0.4 * NoV + 0.4 * alpha * alpha; }

SkyLobe sky_lobe(vec3 normal, vec3 to_viewer, float NoV, float alpha) {
  float lean = dfg_at(NoV, sqrt(alpha)).z * lean_of_rest(NoV, alpha);
  return SkyLobe(lobe_direction(normal, to_viewer, NoV, lean), normal, max(alpha, sky.least_alpha));
}

float shed_on(SkyLobe lobe, vec3 l) { return dot(lobe.normal, l) > 0.0 ? ggx_lobe(dot(lobe.direction, l), lobe.alpha) : 0.0; }

float share_of(float hidden, SkyLobe lobe) {
  return hidden / max(lobe_sum(lobe.direction, lobe.alpha, lobe.normal), 1e-9);
}

vec3 share_of(vec3 hidden, vec3 direction) { return hidden / max(sum_around(direction, 0), vec3(1e-9)); }

// What of each lobe of environment_light() is hidden, in the mean over the sub-frames.
struct HiddenShares {
  vec3 diffuse;
  float specular;
#if FEATURE_DIFFUSE_TRANSMISSION
  vec3 scattered;
#endif
#if FEATURE_SHEEN
  vec3 sheen;
#endif
#if FEATURE_CLEARCOAT
  float clearcoat;
#endif
};

HiddenShares hidden_shares(Surface s) {
  HiddenShares h;
  h.diffuse = vec3(0.0);
  h.specular = 0.0;
#if FEATURE_ANISOTROPY
  SkyLobe specular = sky_lobe(s.normal, s.to_viewer, s.NoV, sqrt(s.alpha * s.alpha_t));
#else
  SkyLobe specular = sky_lobe(s.normal, s.to_viewer, s.NoV, s.alpha);
#endif
#if FEATURE_DIFFUSE_TRANSMISSION
  h.scattered = vec3(0.0);
#endif
#if FEATURE_SHEEN
  h.sheen = vec3(0.0);
  vec3 sheen = sheen_direction(s);
#endif
#if FEATURE_CLEARCOAT
  h.clearcoat = 0.0;
  SkyLobe clearcoat = sky_lobe(s.clearcoat_normal, s.to_viewer, s.clearcoat_NoV, s.clearcoat_alpha);
#endif
  for (uint i = 0u; i < sky.count; ++i) {
    vec3 l = sky.views[i].towards.xyz;
    vec4 hidden = sky.views[i].light * hidden_from(i, s.position, s.vertex_normal);
    float NoL = dot(s.normal, l);
    h.diffuse += hidden.rgb * max(NoL, 0.0);
    h.specular += hidden.a * shed_on(specular, l);
#if FEATURE_DIFFUSE_TRANSMISSION
    h.scattered += hidden.rgb * max(-NoL, 0.0);
#endif
#if FEATURE_SHEEN
    h.sheen += NoL > 0.0 ? hidden.rgb * max(dot(sheen, l), 0.0) : vec3(0.0);
#endif
#if FEATURE_CLEARCOAT
    h.clearcoat += hidden.a * shed_on(clearcoat, l);
#endif
  }
  h.diffuse = share_of(h.diffuse, s.normal);
  h.specular = share_of(h.specular, specular);
#if FEATURE_DIFFUSE_TRANSMISSION
  h.scattered = share_of(h.scattered, -s.normal);
#endif
#if FEATURE_SHEEN
  h.sheen = share_of(h.sheen, sheen);
#endif
#if FEATURE_CLEARCOAT
  h.clearcoat = share_of(h.clearcoat, clearcoat);
#endif
  return h;
}

// Radiance that the specular lobe of the base layer sees.
vec3 seen_specular(Surface s, HiddenShares hidden, float lean_rad) {
  vec3 narrow = reflected_radiance(s.normal, s.to_viewer, s.NoV, lean_rad * lean_of_rest(s.NoV, s.alpha), sqrt(s.alpha));
  vec3 broad = diffuse_radiance(constants.environment_from_world * s.normal);
  return mix(narrow * (1.0 - hidden.specular), broad * (1.0 - hidden.diffuse), broad_share(s.NoV, s.alpha));
}
