// The part of the environment's light that the scene keeps from itself: of the directions that stand for the environment, those
// that see something else of the scene. It is taken from the exact prefiltered light, so that where nothing is hidden nothing
// changes; sub-frames take different directions and their mean converges, though one alone may take more than there is.
#include "interface/sky_block.glsl"
#include "surface/environment_light.glsl"

layout(std140, binding = 5) uniform SkyUniform { SkyBlock sky; };
layout(binding = 16) uniform sampler2DArray sky_depths;

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

// What `environment_light` without occlusion has too much, in the mean.
vec3 hidden_environment_light(vec3 base_color, float metallic, float alpha, vec3 position, vec3 smooth_normal, vec3 normal,
                              vec3 to_viewer, float NoV) {
  float wide_alpha = max(alpha, sky.least_alpha);
  vec3 diffuse = vec3(0.0), specular = vec3(0.0);
  for (uint i = 0u; i < sky.count; ++i) {
    vec3 l = sky.views[i].towards.xyz;
    float NoL = dot(normal, l);
    if (NoL <= 0.0) continue;
    vec3 hidden = sky.views[i].light.rgb * (NoL * hidden_from(i, position, smooth_normal));
    vec3 h = normalize(l + to_viewer);
    float lobe = D_GGX(clamp(dot(normal, h), 0.0, 1.0), wide_alpha) * V_SmithGGXCorrelated(NoV, NoL, wide_alpha);
    diffuse += hidden * INV_PI;
    specular += hidden * lobe;
  }
  float roughness = sqrt(alpha), wide_roughness = sqrt(wide_alpha);
  vec4 dfg = textureLod(dfg_map, vec2(NoV, roughness), 0.0);
  vec4 wide_dfg = textureLod(dfg_map, vec2(NoV, wide_roughness), 0.0);
  // Of a lobe that falls between the directions: as large a share as of one wide enough.
  vec3 wide_lobe = constants.environment_from_world * lobe_direction(normal, to_viewer, NoV, wide_dfg.z);
  vec3 lobe = constants.environment_from_world * lobe_direction(normal, to_viewer, NoV, dfg.z);
  vec3 share = specular / max((wide_dfg.x + wide_dfg.y) * prefiltered_radiance(wide_lobe, wide_roughness), vec3(1e-9));
  Reflectance r = reflectance(base_color, metallic, dfg.xy);
  return r.diffuse * diffuse + r.specular * prefiltered_radiance(lobe, roughness) * share;
}
