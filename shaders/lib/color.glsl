float luminance(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }  // Rec. 709

// IEC 61966-2-1:1999, sRGB.
vec3 srgb_from_linear(vec3 c) {
  vec3 low = c * 12.92;
  vec3 high = 1.055 * pow(max(c, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055;
  return mix(high, low, lessThanEqual(c, vec3(0.0031308)));
}

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
