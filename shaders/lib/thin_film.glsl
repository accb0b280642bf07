// Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence".
#include "lib/brdf.glsl"

// Their fit of the CIE 1931 observer's response to a wave of optical path difference (m) and phase shifts, as linear Rec. 709.
vec3 film_sensitivity(float path_m, vec3 shift) {
  float phase = TWO_PI * path_m;
  const vec3 amplitude = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13);
  const vec3 position = vec3(1.6810e+06, 1.7953e+06, 2.2084e+06);
  const vec3 variance = vec3(4.3278e+09, 9.3046e+09, 6.6121e+09);
  vec3 xyz = amplitude * sqrt(TWO_PI * variance) * cos(position * phase + shift) * exp(-phase * phase * variance);
  xyz.x += 9.7470e-14 * sqrt(TWO_PI * 4.5282e+09) * cos(2.2399e+06 * phase + shift.x) * exp(-4.5282e+09 * phase * phase);
  xyz /= 1.0685e-7;
  const mat3 rec709_from_xyz = mat3(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314,
                                    0.0415560, 1.0572252);
  return rec709_from_xyz * xyz;
}

// Reflectance of a film on a base of reflectance `base_f0`, seen from air under `cosine`.
vec3 thin_film_reflectance(float cosine, float film_ior, float thickness_nm, vec3 base_f0) {
  // A film without thickness is none.
  float ior = mix(1.0, film_ior, smoothstep(0.0, 0.03, thickness_nm));
  float sine2 = (1.0 - cosine * cosine) / (ior * ior);
  if (sine2 >= 1.0) return vec3(1.0);
  float inner_cosine = sqrt(1.0 - sine2);

  float r0 = (ior - 1.0) / (ior + 1.0);
  float R12 = F_Schlick(cosine, vec3(r0 * r0), vec3(1.0)).x;
  float T121 = 1.0 - R12;
  float phase_12 = ior < 1.0 ? PI : 0.0;

  vec3 root = sqrt(clamp(base_f0, 0.0, 0.9999));
  vec3 base_ior = (1.0 + root) / (1.0 - root);
  vec3 r1 = (base_ior - ior) / (base_ior + ior);
  vec3 R23 = F_Schlick(inner_cosine, r1 * r1, vec3(1.0));
  vec3 phase_23 = mix(vec3(0.0), vec3(PI), lessThan(base_ior, vec3(ior)));

  float path_m = 2.0e-9 * ior * thickness_nm * inner_cosine;
  vec3 phase = PI - phase_12 + phase_23;
  vec3 R123 = min(R12 * R23, vec3(0.9999));
  vec3 r123 = sqrt(R123);
  vec3 Rs = T121 * T121 * R23 / (1.0 - R123);
  vec3 sum = R12 + Rs;
  vec3 C = Rs - T121;
  for (int m = 1; m <= 2; ++m) {
    C *= r123;
    sum += C * 2.0 * film_sensitivity(float(m) * path_m, float(m) * phase);
  }
  return max(sum, vec3(0.0));
}

// The F0 that gives this reflectance under `cosine` by Schlick's approximation.
vec3 f0_of_reflectance(vec3 reflectance, float cosine) {
  float m = clamp(1.0 - cosine, 0.0, 1.0);
  float grazing = min(m * m * m * m * m, 0.9999);
  return clamp((reflectance - grazing) / (1.0 - grazing), 0.0, 1.0);
}
