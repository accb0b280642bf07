// Tone curves: exposed linear radiance of at least 0 -> linear picture; what exceeds 1 is for the caller to clip.
#include "lib/color.glsl"

// Khronos 2024, "Khronos PBR Neutral Tone Mapper" specification: base colours below the shoulder keep their value less a
// Fresnel offset of 0.04; only highlights are compressed and desaturated.
vec3 tone_pbr_neutral(vec3 c) {
  const float start_compression = 0.8 - 0.04;
  const float desaturation = 0.15;
  float lowest = min(c.r, min(c.g, c.b));
  float offset = lowest < 0.08 ? lowest - 6.25 * lowest * lowest : 0.04;
  c -= offset;
  float peak = max(c.r, max(c.g, c.b));
  if (peak < start_compression) return c;
  float d = 1.0 - start_compression;
  float new_peak = 1.0 - d * d / (peak + d - start_compression);
  c *= new_peak / peak;
  float g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
  return mix(c, vec3(new_peak), g);
}

// Hill 2016, "Baking Lab" (ACES.hlsl): a rational fit of the reference rendering and sRGB output transforms of the Academy
// Color Encoding System. Viewers of glTF expose it by 1 / 0.6, for mid grey to be about as bright as under other curves.
vec3 tone_aces(vec3 c) {
  const mat3 rrt_from_rec709 =
      mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
  const mat3 rec709_from_odt =
      mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
  const float highest = 65504.0;  // the fit is 1 long before; its squares must not overflow
  c = rrt_from_rec709 * min(c / 0.6, vec3(highest));
  c = (c * (c + 0.0245786) - 0.000090537) / (c * (0.983729 * c + 0.4329510) + 0.238081);
  return rec709_from_odt * c;
}

// Sobotka 2022, "AgX": primaries drawn in, a sigmoid of the logarithm, primaries spread again. Its base look within Rec.2020
// in the rational matrices of Filament; the sigmoid is the sixth-order polynomial of Wrensch 2023, "Minimal AgX
// Implementation", whose result is for a display of gamma 2.2.
vec3 tone_agx(vec3 c) {
  const mat3 rec2020_from_rec709 =
      mat3(0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0113, 0.8956);
  const mat3 rec709_from_rec2020 =
      mat3(1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187);
  const mat3 inset = mat3(0.856627153315983, 0.137318972929847, 0.11189821299995,     //
                          0.0951212405381588, 0.761241990602591, 0.0767994186031903,  //
                          0.0482516061458583, 0.101439036467562, 0.811302368396859);
  const mat3 outset = mat3(1.1271005818144368, -0.1413297634984383, -0.14132976349843826,   //
                           -0.11060664309660323, 1.157823702216272, -0.11060664309660294,   //
                           -0.016493938717834573, -0.016493938717834257, 1.2519364065950405);
  const float lowest_ev = -12.47393, highest_ev = 4.026069;
  const float darkest = 1e-10;  // far below lowest_ev, for the logarithm
  c = inset * (rec2020_from_rec709 * c);
  vec3 x = clamp((log2(max(c, vec3(darkest))) - lowest_ev) / (highest_ev - lowest_ev), 0.0, 1.0);
  vec3 s = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x) - 0.00232;
  return rec709_from_rec2020 * pow(max(outset * s, vec3(0.0)), vec3(2.2));
}

// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", eq. 3, of luminance.
vec3 tone_reinhard(vec3 c) { return c / (1.0 + luminance(c)); }
