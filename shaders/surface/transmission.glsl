// What is seen through a surface: KHR_materials_transmission, _volume and _dispersion. Behind it stands the backdrop, a picture of
// all that is not seen through, and behind that the background.
#include "lib/bicubic.glsl"

layout(binding = 30) uniform sampler2D backdrop_map;  // premultiplied radiance of the whole picture, without background; mipmapped
layout(binding = 31) uniform sampler2D behind_map;    // the background's equirect map

// Radiance of the background in a unit direction of the world, or behind a place of the picture ([0, 1], down).
vec3 behind_radiance(vec3 direction, vec2 place, float perceptual_roughness) {
  if (frame.backdrop_kind == BACKDROP_COLOR) return mix(frame.background_top.rgb, frame.background_bottom.rgb, place.y);
  if (frame.backdrop_kind == BACKDROP_TRANSPARENT) return vec3(0.0);
  vec3 in_background = mat3(frame.background_from_world) * direction;
  vec2 uv = equirect_from_direction(in_background);
  float rows = float(textureSize(behind_map, 0).y);
  // A lobe of this alpha is about as wide as so many texels.
  float alpha = perceptual_roughness * perceptual_roughness;
  float lod = max(log2(max(alpha * rows, 1e-6)), max(frame.background_lod, 0.0));
  vec3 sharp = textureLod(behind_map, uv, lod).rgb * frame.background_gain;
  if (frame.backdrop_kind != BACKDROP_LIGHT) return sharp;
  float share = clamp(level_coordinate(perceptual_roughness) / frame.level_tiles[0].w, 0.0, 1.0);
  if (share == 0.0) return sharp;
  return mix(sharp, prefiltered_radiance(in_background, perceptual_roughness) * frame.background_share, share);
}

// Where a ray that enters leaves again, and where it then looks.
struct Refraction {
  vec3 exit_world, direction;
};

// Snell's law where it enters; where it leaves as of a pane or, the rounder the surface, of a ball of that thickness.
Refraction refracted(Surface s, float ior) {
  if (s.thickness_m <= 0.0) return Refraction(s.position, -s.to_viewer);
  vec3 inside = refract(-s.to_viewer, s.normal, 1.0 / ior);
  vec3 ball_end = s.normal - 2.0 * dot(s.normal, inside) * inside;  // outward normal where a ball is left
  vec3 end = normalize(mix(-s.normal, ball_end, s.roundness));
  vec3 outside = refract(inside, -end, ior);
  return Refraction(s.position + inside * s.thickness_m, dot(outside, outside) > 0.0 ? outside : inside);
}

// xyz: premultiplied radiance of what is behind; w: the share of it that is not background.
vec4 seen_through(Surface s, float ior, float perceptual_roughness, out vec3 behind) {
  Refraction ray = refracted(s, ior);
  vec4 clip = frame.backdrop_from_world * vec4(ray.exit_world, 1.0);
  vec2 place = clip.xy / max(clip.w, 1e-6);
  // Half the picture's height is blurred away at roughness 1: the distance to what is behind is not known.
  float lod = perceptual_roughness * log2(float(textureSize(backdrop_map, 0).y));
  behind = behind_radiance(ray.direction, place, perceptual_roughness);
  return bicubic_lod(backdrop_map, place, lod);
}

#if FEATURE_ALPHA_BLEND
// A surface that covers a part of what is straight behind it. `radiance` as surface_radiance() gives it.
vec4 covering(Surface s, vec4 radiance) {
  vec4 clip = frame.backdrop_from_world * vec4(s.position, 1.0);
  vec2 place = clip.xy / max(clip.w, 1e-6);
  vec4 straight = textureLod(backdrop_map, place, 0.0);
  straight.rgb += (1.0 - straight.a) * behind_radiance(-s.to_viewer, place, 0.0);
  if (frame.backdrop_kind != BACKDROP_TRANSPARENT) straight.a = 1.0;
  return mix(straight, radiance, s.base_color.a);
}
#endif

// `weight`: what the surface lets through, by colour.
void add_transmitted(Surface s, vec3 weight, inout vec3 through, inout vec3 see_through) {
  float ior = layers.transmission.y;
  weight *= exp(-layers.absorption.rgb * s.thickness_m);
  // KHR_materials_dispersion: the index of refraction at the ends of the spectrum.
  float half_spread = s.thickness_m > 0.0 ? (ior - 1.0) * 0.025 * layers.transmission.w : 0.0;
  vec3 radiance = vec3(0.0), background_share = vec3(0.0);
  int rays = half_spread > 0.0 ? 3 : 1;
  for (int i = 0; i < rays; ++i) {
    vec3 channels = rays == 1 ? vec3(1.0) : vec3(equal(ivec3(i), ivec3(0, 1, 2)));
    vec3 behind;
    vec4 seen = seen_through(s, ior + (rays == 1 ? 0.0 : float(i - 1) * half_spread), s.transmitted_roughness, behind);
    radiance += channels * (seen.rgb + (1.0 - seen.a) * behind);
    background_share += channels * (1.0 - seen.a);
  }
  through += weight * radiance;
  if (frame.backdrop_kind == BACKDROP_TRANSPARENT) see_through += weight * background_share;
}
