// Light of surfaces that shine: rectangles, discs and balls.
#include "surface/environment_light.glsl"
#include "surface/light_at.glsl"

// With the viewer above x.
mat3 shading_frame(vec3 normal, vec3 to_viewer) {
  vec3 x = to_viewer - dot(to_viewer, normal) * normal;
  float length2 = dot(x, x);
  return plane_frame(normal, length2 > 1e-8 ? x * inversesqrt(length2) : unit_across(normal));
}

// See renderer/ibl/ltc.hpp.
mat3 specular_lobe_frame(vec3 normal, vec3 to_viewer, float NoV, float alpha) {
  vec4 ltc = textureLod(lobe_tables, vec3(sqrt(1.0 - NoV), sqrt(alpha), 1.0), 0.0);
  float width = max(alpha, 1e-3);
  mat3 cosine_from_frame = mat3(ltc.x, 0.0, width * ltc.z, 0.0, 1.0, 0.0, ltc.y, 0.0, width * ltc.w);
  return cosine_from_frame * shading_frame(normal, to_viewer);
}

#if FEATURE_ANISOTROPY
float anisotropic_share(Outline o, ivec2 corners, Surface s) {
  float sum = 0.0, weights = 0.0;
  for (int i = 0; i < ANISOTROPIC_TAPS; ++i) {
    AnisotropicTap tap = anisotropic_tap(s, i);
    if (tap.weight > 0.0)
      sum += tap.weight * lobe_share(o, corners, specular_lobe_frame(tap.normal, s.to_viewer, tap.VoH, tap.alpha));
    weights += tap.weight;
  }
  return weights > 0.0 ? sum / weights : 0.0;
}
#endif

// Places in the array of lobes below.
const int LOBE_DIFFUSE = 0;
const int LOBE_SPECULAR = 1;
const int LOBE_SCATTERED = 2;
const int LOBE_SEEN = LOBE_SCATTERED + FEATURE_DIFFUSE_TRANSMISSION;
const int LOBE_SHEEN = LOBE_SEEN + FEATURE_TRANSMISSION;
const int LOBE_COAT = LOBE_SHEEN + FEATURE_SHEEN;
const int LOBES = LOBE_COAT + FEATURE_CLEARCOAT;

// `radiance`: of the light, less what is in the way.
void add_surface_light(Surface s, Lit lit, LightRow light, vec3 radiance, float distance_m, inout Leaving leaving) {
  Outline o = outline_of(light, s.position);
  ivec2 part = ivec2(light.cone.xy);
  ivec2 whole = whole_outline(light);
  mat3 lobes[LOBES];
  float alphas[LOBES];  // of what is no cosine from the start
  for (int k = 0; k < LOBES; ++k) alphas[k] = 1.0;
  lobes[LOBE_DIFFUSE] = shading_frame(s.normal, s.to_viewer);
  lobes[LOBE_SPECULAR] = specular_lobe_frame(s.normal, s.to_viewer, s.NoV, s.alpha);
  alphas[LOBE_SPECULAR] = s.alpha;
#if FEATURE_DIFFUSE_TRANSMISSION
  lobes[LOBE_SCATTERED] = shading_frame(-s.normal, s.to_viewer);
#endif
#if FEATURE_TRANSMISSION
  // As lights behind a thin wall: their mirror images before it.
  alphas[LOBE_SEEN] = s.transmitted_roughness * s.transmitted_roughness;
  lobes[LOBE_SEEN] = specular_lobe_frame(s.normal, s.to_viewer, s.NoV, alphas[LOBE_SEEN]) *
                     (mat3(1.0) - 2.0 * outerProduct(s.normal, s.normal));
#endif
#if FEATURE_SHEEN
  lobes[LOBE_SHEEN] = shading_frame(sheen_direction(s), s.to_viewer);
#endif
#if FEATURE_CLEARCOAT
  lobes[LOBE_COAT] = specular_lobe_frame(s.clearcoat_normal, s.to_viewer, s.clearcoat_NoV, s.clearcoat_alpha);
  alphas[LOBE_COAT] = s.clearcoat_alpha;
#endif
  // A sub-frame's part of the light, but all of it in lobes that would show the borders between the parts. One loop, so that
  // drivers compile its body once.
  float shares[LOBES];
  for (int k = 0; k < LOBES; ++k) {
    float in_part = smoothstep(0.5, 2.0, 2.0 * alphas[k] * distance_m / max(light.eye.w, 1e-6 * distance_m));
    shares[k] = 0.0;
    for (int all = 0; all < 2; ++all) {
      float weight = all == 0 ? in_part * light.intensity.w : 1.0 - in_part;
      if (weight > 0.0) shares[k] += weight * lobe_share(o, all == 0 ? part : whole, lobes[k]);
    }
  }
#if FEATURE_ANISOTROPY
  shares[LOBE_SPECULAR] = anisotropic_share(o, part, s);
#endif
  leaving.diffuse += radiance * lit.body.reflected * shares[LOBE_DIFFUSE];
  leaving.specular += radiance * lit.albedo * shares[LOBE_SPECULAR];
#if FEATURE_DIFFUSE_TRANSMISSION
  leaving.diffuse += radiance * lit.body.scattered * shares[LOBE_SCATTERED];
#endif
#if FEATURE_TRANSMISSION
  leaving.through += radiance * lit.body.seen * exp(-layers.absorption.rgb * s.thickness_m) * shares[LOBE_SEEN];
#endif
#if FEATURE_SHEEN
  leaving.sheen += radiance * s.sheen_color * sheen_albedo(s.NoV, s.sheen_roughness) * shares[LOBE_SHEEN];
#endif
#if FEATURE_CLEARCOAT
  leaving.clearcoat += radiance * specular_albedo(vec3(0.04), vec3(1.0), clearcoat_dfg(s).xy) * shares[LOBE_COAT];
#endif
}
