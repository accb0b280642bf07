// Light of the baked environment: split sum (Karis 2013) with exact prefiltered levels.
#include "interface/frame_block.glsl"
#include "lib/brdf.glsl"
#include "lib/sphere.glsl"
#include "surface/constants.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };  // for its levels

layout(binding = 5) uniform sampler2D sky_map;    // the environment itself, equirect
layout(binding = 6) uniform sampler2D atlas_map;  // octahedral tiles: GGX levels and irradiance
layout(binding = 7) uniform sampler2D dfg_map;    // x: roughness row, see renderer/ibl/dfg.hpp

vec3 sample_tile(vec4 tile, vec2 octahedral) {
  return textureLod(atlas_map, (tile.xy + octahedral * tile.z) * constants.atlas.xy, 0.0).rgb;
}

vec3 sample_sky(vec3 direction, float lod) {
  return textureLod(sky_map, equirect_from_direction(direction), lod).rgb * constants.atlas.w;
}

// Radiance around unit `direction` (environment frame), prefiltered for a perceptual roughness.
vec3 prefiltered_radiance(vec3 direction, float perceptual_roughness) {
  float at = level_coordinate(perceptual_roughness);
  // The last level at or below the roughness, by bisection.
  uint low = 0u;
  for (uint step = 16u; step > 0u; step >>= 1u) {
    uint probe = low + step;
    if (probe < frame.level_count && frame.level_tiles[probe].w <= at) low = probe;
  }
  uint high = min(low + 1u, frame.level_count - 1u);
  vec4 tile_low = frame.level_tiles[low];
  vec4 tile_high = frame.level_tiles[high];
  float t = clamp((at - tile_low.w) / max(tile_high.w - tile_low.w, 1e-9), 0.0, 1.0);
  vec2 octahedral = octahedral_from_direction(direction);
  vec3 radiance = mix(sample_tile(tile_low, octahedral), sample_tile(tile_high, octahedral), t) * constants.irradiance_tile.w;
#if FEATURE_SHARP_REFLECTION
  float first = frame.level_tiles[0].w;
  if (at < first) {
    radiance = mix(sample_sky(direction, 0.0), radiance, at / first);
  }
#endif
  return radiance;
}

// E / pi around unit `direction` (environment frame).
vec3 diffuse_radiance(vec3 direction) {
  return sample_tile(constants.irradiance_tile, octahedral_from_direction(direction)) * constants.irradiance_tile.w;
}

struct Reflectance {
  vec3 diffuse;   // directional albedo of the diffuse lobe
  vec3 specular;  // directional albedo of the specular lobe
};

// glTF 2.0 appendix B: a mix by metallic of a dielectric (F0 = 0.04 over Lambert) and a metal (F0 = base colour). What the
// dielectric's surface reflects does not reach its diffuse base, so a white furnace stays white.
Reflectance reflectance(vec3 base_color, float metallic, vec2 dfg) {
  vec3 dielectric = specular_albedo(vec3(0.04), dfg);
  Reflectance r;
  r.specular = mix(dielectric, specular_albedo(base_color, dfg), metallic);
  r.diffuse = (1.0 - metallic) * base_color * (1.0 - dielectric);
  return r;
}

// The lobe of a rough surface leans from the mirror direction towards the normal by `lean_rad`.
vec3 lobe_direction(vec3 normal, vec3 to_viewer, float NoV, float lean_rad) {
  vec3 mirror = reflect(-to_viewer, normal);
  float sine = sqrt(max(1.0 - NoV * NoV, 0.0));
  // Spherical interpolation: (sin(theta - lean) mirror + sin(lean) normal) / sin(theta).
  // Never past the normal: near it the table's interpolation would, in a dot at the middle of a sphere.
  lean_rad = min(lean_rad, asin(min(sine, 1.0)));
  float lean_sine = sin(lean_rad);
  vec3 leant = (sine * cos(lean_rad) - NoV * lean_sine) * mirror + lean_sine * normal;
  return sine > 1e-3 ? normalize(leant) : mirror;
}

vec3 environment_light(vec3 base_color, float metallic, float alpha, float occlusion, vec3 normal, vec3 to_viewer,
                       float NoV) {
  float perceptual_roughness = sqrt(alpha);
  vec4 dfg = textureLod(dfg_map, vec2(NoV, perceptual_roughness), 0.0);
  Reflectance r = reflectance(base_color, metallic, dfg.xy);
  vec3 lobe = constants.environment_from_world * lobe_direction(normal, to_viewer, NoV, dfg.z);
  vec3 specular = r.specular * prefiltered_radiance(lobe, perceptual_roughness);
  vec3 diffuse = r.diffuse * diffuse_radiance(constants.environment_from_world * normal);
  return diffuse * occlusion + specular * specular_occlusion(NoV, occlusion, alpha);
}
