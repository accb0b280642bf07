// The part of the environment's light that the scene keeps from itself: of directions that stand for the environment, those that
// see something else of the scene. Each sub-frame looks along some; what they find hidden is taken as a share of what all of all
// sub-frames shed on the lobe, a number that is known before, so that the mean over the sub-frames has no bias: it is the share
// that all directions together find. Where nothing is hidden the prefiltered light stays as it is.
#include "interface/sky_block.glsl"
#include "surface/environment_light.glsl"

layout(std140, binding = 5) uniform SkyUniform { SkyBlock sky; };
layout(binding = 16) uniform sampler2DArray sky_depths;
layout(binding = 17) uniform sampler2D sky_sums;  // of all directions: renderer/ibl/light_sums.hpp

// 0 .. 1: whether something hides the direction.
float hidden_from(uint i, vec3 position, vec3 normal) {
  SkyView view = sky.views[i];
  vec3 l = view.towards.xyz;
  // Off the surface by some texels, more where the light grazes it, so that it does not shadow itself.
  float cosine = clamp(dot(normal, l), 0.0, 1.0);
  vec4 lifted = vec4(position + (normal * sqrt(1.0 - cosine * cosine) + l) * view.towards.w, 1.0);
  // One texel: the maps of all directions lie differently over the surface, so that their mean has no steps.
  vec2 uv = vec2(dot(view.map_u, lifted), dot(view.map_v, lifted));
  float depth = texelFetch(sky_depths, ivec3(ivec2(uv * sky.map_px), i), 0).r;
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
// 1 / (1 + (u / s)^2)^2 has (1 + x / sqrt(x^2 + s^2)) / 2 beyond a line at a distance x. Here s is 2 alpha, x the elevation.
float lobe_sum(vec3 direction, float alpha, vec3 normal) {
  float at = clamp(1.0 - log(alpha) / log(sky.least_alpha), 0.0, 1.0) * float(SKY_LOBES - 1);
  int low = min(int(at), SKY_LOBES - 2);
  float sum = mix(sum_around(direction, 1 + low).r, sum_around(direction, 2 + low).r, at - float(low));
  float elevation = asin(clamp(dot(direction, normal), -1.0, 1.0));
  return sum * (0.5 + 0.5 * elevation * inversesqrt(elevation * elevation + 4.0 * alpha * alpha));
}

// What `environment_light` without occlusion has too much, in the mean over the sub-frames.
vec3 hidden_environment_light(vec3 base_color, float metallic, float alpha, vec3 position, vec3 smooth_normal, vec3 normal,
                              vec3 to_viewer, float NoV) {
  float roughness = sqrt(alpha);
  vec4 dfg = textureLod(dfg_map, vec2(NoV, roughness), 0.0);
  vec3 lobe = lobe_direction(normal, to_viewer, NoV, dfg.z);
  float wide_alpha = max(alpha, sky.least_alpha);
  vec3 diffuse = vec3(0.0);
  float specular = 0.0;
  for (uint i = 0u; i < sky.count; ++i) {
    vec3 l = sky.views[i].towards.xyz;
    float NoL = dot(normal, l);
    if (NoL <= 0.0) continue;
    vec4 hidden = sky.views[i].light * hidden_from(i, position, smooth_normal);
    diffuse += hidden.rgb * NoL;
    specular += hidden.a * ggx_lobe(dot(lobe, l), wide_alpha);
  }
  vec3 diffuse_share = diffuse / max(sum_around(normal, 0), vec3(1e-9));
  float specular_share = specular / max(lobe_sum(lobe, wide_alpha, normal), 1e-9);
  Reflectance r = reflectance(base_color, metallic, dfg.xy);
  return r.diffuse * diffuse_share * diffuse_radiance(constants.environment_from_world * normal) +
         r.specular * specular_share * prefiltered_radiance(constants.environment_from_world * lobe, roughness);
}
