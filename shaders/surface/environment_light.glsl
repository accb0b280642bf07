// Light of the baked environment: split sum (Karis 2013) with exact prefiltered levels.
#include "interface/frame_block.glsl"
#include "lib/brdf_layers.glsl"
#include "lib/color.glsl"
#include "lib/lobe_tables.glsl"
#include "lib/sphere.glsl"
#include "surface/constants.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };  // for its levels

layout(binding = 5) uniform sampler2D sky_map;    // the environment itself, equirect
layout(binding = 6) uniform sampler2D atlas_map;  // octahedral tiles: GGX levels and irradiance

// Scale and bias of the split sum, lean of the lobe, albedo of the sheen.
vec4 dfg_at(float NoV, float perceptual_roughness) {
  return textureLod(lobe_tables, vec3(NoV, perceptual_roughness, 0.0), 0.0);
}

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

#if FEATURE_TRANSMISSION
#include "surface/transmission.glsl"
#endif

// E / pi around unit `direction` (environment frame).
vec3 diffuse_radiance(vec3 direction) {
  return sample_tile(constants.irradiance_tile, octahedral_from_direction(direction)) * constants.irradiance_tile.w;
}

// Directional albedos of the lobes of the base layer.
struct Reflectance {
  vec3 specular;
  vec3 f0, f90;  // of the specular lobe, which they add up to with the scale and bias of the split sum
  vec3 body;  // of what enters a dielectric: shared by all that happens within it
};

// glTF 2.0 appendix B: a mix by metallic of a dielectric and a metal (F0 = base colour). What the dielectric's surface
// reflects does not reach its body, so a white furnace stays white; the greatest of the channels is held back from all, so
// that a coloured reflection leaves no complementary colour (KHR_materials_specular).
Reflectance reflectance(Surface s, vec2 dfg) {
  vec3 dielectric_gain = multiple_scattering(s.f0, dfg), metal_gain = multiple_scattering(s.metal_f0, dfg);
  vec3 dielectric = (s.f0 * dfg.x + s.f90 * dfg.y) * dielectric_gain;
  Reflectance r;
  r.f0 = mix(s.f0 * dielectric_gain, s.metal_f0 * metal_gain, s.metallic);
  r.f90 = mix(s.f90 * dielectric_gain, metal_gain, s.metallic);
  r.specular = r.f0 * dfg.x + r.f90 * dfg.y;
  r.body = vec3((1.0 - s.metallic) * max(1.0 - max_component(dielectric), 0.0));
  return r;
}

// Light that leaves a surface, by where it came through; layered() puts the layers together.
struct Leaving {
  vec3 diffuse, specular;
  vec3 through;       // what was behind, seen through it
  vec3 see_through;   // share of the light of a transparent background that passes
#if FEATURE_SHEEN
  vec3 sheen;
#endif
#if FEATURE_CLEARCOAT
  vec3 clearcoat;
#endif
};

// What becomes of the body's share, r.body: reflected diffusely, scattered through, seen through.
struct BodyShares {
  vec3 reflected, scattered, seen;
};

BodyShares body_shares(Surface s, vec3 body) {
  BodyShares b = BodyShares(body * s.base_color.rgb, vec3(0.0), vec3(0.0));
#if FEATURE_DIFFUSE_TRANSMISSION
  b.scattered = body * s.diffuse_transmission_color * s.diffuse_transmission;
  b.reflected *= 1.0 - s.diffuse_transmission;
#endif
#if FEATURE_TRANSMISSION
  b.seen = body * s.base_color.rgb * s.transmission;
  b.reflected *= 1.0 - s.transmission;
  b.scattered *= 1.0 - s.transmission;
#endif
  return b;
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

vec3 reflected_radiance(vec3 normal, vec3 to_viewer, float NoV, float lean_rad, float perceptual_roughness) {
  vec3 lobe = constants.environment_from_world * lobe_direction(normal, to_viewer, NoV, lean_rad);
  return prefiltered_radiance(lobe, perceptual_roughness);
}

#if FEATURE_ANISOTROPY
// Radiance of a lobe wider along the tangent: round lobes of the narrow width, about normals tilted along the tangent as the
// slopes of GGX are spread beyond that width. Along one axis they have the density a^2 / (2 (a^2 + x^2)^(3/2)), so the
// quantile of u in (-1, 1) is x = a u / sqrt(1 - u^2).
struct AnisotropicTap {
  vec3 normal;
  float VoH, alpha, weight;
};

const int ANISOTROPIC_TAPS = 12;

AnisotropicTap anisotropic_tap(Surface s, int i) {
  AnisotropicTap tap;
  float spread = sqrt(max(s.alpha_t * s.alpha_t - s.alpha * s.alpha, 0.0));
  // No sharper than the taps lie apart.
  tap.alpha = max(s.alpha, 0.15 * spread);
  float u = (2.0 * float(i) + 1.0) / float(ANISOTROPIC_TAPS) - 1.0;
  tap.normal = normalize(s.normal + s.tangent * (spread * u * inversesqrt(1.0 - u * u)));
  tap.VoH = dot(s.to_viewer, tap.normal);
  float NoL = dot(s.normal, reflect(-s.to_viewer, tap.normal));
  // Of a half vector drawn from D cos: G (v.h) / (n.h n.v), here by the masking of the light alone.
  tap.weight = tap.VoH > 0.0 && NoL > 0.0
                   ? tap.VoH * 2.0 * NoL / (NoL + sqrt(s.alpha_t * s.alpha_t + (1.0 - s.alpha_t * s.alpha_t) * NoL * NoL))
                   : 0.0;
  return tap;
}

vec3 anisotropic_radiance(Surface s) {
  float tap_roughness = sqrt(anisotropic_tap(s, 0).alpha);
  float lean = dfg_at(s.NoV, tap_roughness).z;
  vec3 sum = vec3(0.0);
  float weights = 0.0;
  for (int i = 0; i < ANISOTROPIC_TAPS; ++i) {
    AnisotropicTap tap = anisotropic_tap(s, i);
    if (tap.weight <= 0.0) continue;
    sum += tap.weight * reflected_radiance(tap.normal, s.to_viewer, tap.VoH, lean, tap_roughness);
    weights += tap.weight;
  }
  return weights > 0.0 ? sum / weights : prefiltered_radiance(constants.environment_from_world * s.normal, tap_roughness);
}
#endif

#if FEATURE_SHEEN
// The lobe of fibres is about as wide as a cosine's.
vec3 sheen_direction(Surface s) {
  float lean = charlie_lean(s.sheen_roughness);
  vec3 across = s.to_viewer - s.NoV * s.normal;
  return normalize(cos(lean) * s.normal + sin(lean) * across / max(length(across), 0.3));
}

// Directional albedo for a white fibre.
float sheen_albedo(float NoV, float perceptual_roughness) {
  return dfg_at(NoV, perceptual_roughness).w;
}
#endif

#if FEATURE_CLEARCOAT
vec4 clearcoat_dfg(Surface s) { return dfg_at(s.clearcoat_NoV, sqrt(s.clearcoat_alpha)); }
#endif

// Of the environment, within the specular lobe of the base layer.
vec3 specular_radiance(Surface s, float lean_rad, float perceptual_roughness) {
#if FEATURE_ANISOTROPY
  return anisotropic_radiance(s);
#else
  return reflected_radiance(s.normal, s.to_viewer, s.NoV, lean_rad, perceptual_roughness);
#endif
}

// How far that lobe leans towards the normal; those of the older models look into the mirror direction.
float lobe_lean(Surface s) {
#if FEATURE_PHONG || FEATURE_SCHLICK_BECKMANN
  return 0.0;
#else
  return dfg_at(s.NoV, sqrt(s.alpha)).z;
#endif
}
#if FEATURE_ENVIRONMENT_VISIBILITY
#include "surface/environment_visibility.glsl"
#endif

Leaving environment_light(Surface s) {
#if FEATURE_ENVIRONMENT_VISIBILITY
  s.occlusion = 1.0;  // as path tracers do: a map of it would darken again
  HiddenShares hidden = hidden_shares(s);
#endif
  float perceptual_roughness = sqrt(s.alpha);
  Leaving out_light;
  vec3 normal_in_environment = constants.environment_from_world * s.normal;
#if FEATURE_PHONG
  // Ambient and a mirror blurred: neither knows Fresnel's term.
  vec3 specular_color = mix(s.f0, s.metal_f0, s.metallic);
  BodyShares body = body_shares(s, vec3(1.0 - s.metallic));
  out_light.specular =
      specular_color * reflected_radiance(s.normal, s.to_viewer, s.NoV, 0.0, perceptual_roughness);
#elif FEATURE_SCHLICK_BECKMANN
  vec2 dfg = schlick_beckmann_dfg(s.NoV, perceptual_roughness);
  vec3 specular_color = mix(s.f0, s.metal_f0, s.metallic);
  BodyShares body = body_shares(s, (1.0 - s.metallic) * (1.0 - F_Schlick(s.NoV, s.f0, s.f90)));
  out_light.specular = (specular_color * dfg.x + dfg.y) *
                       reflected_radiance(s.normal, s.to_viewer, s.NoV, 0.0, perceptual_roughness);
#else
#if FEATURE_ANISOTROPY
  perceptual_roughness = sqrt(sqrt(s.alpha * s.alpha_t));
#endif
  vec4 dfg = dfg_at(s.NoV, perceptual_roughness);
  Reflectance r = reflectance(s, dfg.xy);
  BodyShares body = body_shares(s, r.body);
#if FEATURE_ENVIRONMENT_VISIBILITY && !FEATURE_ANISOTROPY
  out_light.specular = r.specular * seen_radiance(hidden.specular_lobe, hidden.specular, s.alpha, r.f0, r.f90);
#else
  out_light.specular = r.specular * specular_radiance(s, dfg.z, perceptual_roughness);
#endif
#endif
  out_light.diffuse = body.reflected * diffuse_radiance(normal_in_environment) * s.occlusion;
  out_light.specular *= specular_occlusion(s.NoV, s.occlusion, s.alpha);
  out_light.through = vec3(0.0);
  out_light.see_through = vec3(0.0);
#if FEATURE_DIFFUSE_TRANSMISSION
  vec3 scattered = body.scattered * diffuse_radiance(-normal_in_environment);
#endif
#if FEATURE_TRANSMISSION
  add_transmitted(s, body.seen, out_light.through, out_light.see_through);
#endif
#if FEATURE_SHEEN
  out_light.sheen = s.sheen_color * sheen_albedo(s.NoV, s.sheen_roughness) *
                    diffuse_radiance(constants.environment_from_world * sheen_direction(s)) * s.occlusion;
#endif
#if FEATURE_CLEARCOAT
  vec4 coat_dfg = clearcoat_dfg(s);
#if FEATURE_ENVIRONMENT_VISIBILITY
  out_light.clearcoat =
      seen_radiance(hidden.clearcoat_lobe, hidden.clearcoat, s.clearcoat_alpha, vec3(0.04), vec3(1.0));
#else
  out_light.clearcoat = reflected_radiance(s.clearcoat_normal, s.to_viewer, s.clearcoat_NoV, coat_dfg.z,
                                           sqrt(s.clearcoat_alpha));
#endif
  out_light.clearcoat *= specular_albedo(vec3(0.04), vec3(1.0), coat_dfg.xy) *
                        specular_occlusion(s.clearcoat_NoV, s.occlusion, s.clearcoat_alpha);
#endif
#if FEATURE_ENVIRONMENT_VISIBILITY
  out_light.diffuse *= 1.0 - hidden.diffuse;
#if FEATURE_PHONG || FEATURE_SCHLICK_BECKMANN || FEATURE_ANISOTROPY
  out_light.specular *= 1.0 - round_hidden(hidden.specular_lobe, hidden.specular);
#endif
#if FEATURE_DIFFUSE_TRANSMISSION
  scattered *= 1.0 - hidden.scattered;
#endif
#if FEATURE_SHEEN
  out_light.sheen *= 1.0 - hidden.sheen;
#endif
#endif
#if FEATURE_DIFFUSE_TRANSMISSION
  out_light.diffuse += scattered;
#endif
  return out_light;
}

// The layers over one another. xyz: radiance; w: opacity, less than 1 only where a transparent background is seen through.
vec4 layered(Surface s, Leaving l) {
  vec3 radiance = l.diffuse + l.specular + l.through;
  vec3 see_through = l.see_through;
#if FEATURE_SHEEN
  // KHR_materials_sheen: what the fibres send back does not reach the rest.
  float under_sheen = max(1.0 - max_component(s.sheen_color) * sheen_albedo(s.NoV, s.sheen_roughness), 0.0);
  radiance = radiance * under_sheen + l.sheen;
  see_through *= under_sheen;
#endif
  radiance += s.emissive;
#if FEATURE_CLEARCOAT
  float under_coat = 1.0 - s.clearcoat * specular_albedo(vec3(0.04), vec3(1.0), clearcoat_dfg(s).xy).x;
  radiance = radiance * under_coat + s.clearcoat * l.clearcoat;
  see_through *= under_coat;
#endif
  return vec4(radiance, 1.0 - luminance(see_through));
}
