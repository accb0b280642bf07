#include "lib/constants.glsl"

// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces": GGX; alpha = perceptual roughness squared.
float D_GGX(float NoH, float alpha) {
  float a2 = alpha * alpha;
  // (NoH^2 (a2 - 1) + 1) without the cancellation near NoH = 1.
  float d = (1.0 - NoH * NoH) + a2 * NoH * NoH;
  return a2 / (PI * d * d);
}

// Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs": height-correlated Smith,
// V = G / (4 NoL NoV).
float V_SmithGGXCorrelated(float NoV, float NoL, float alpha) {
  float a2 = alpha * alpha;
  float lambda_v = NoL * sqrt(NoV * NoV * (1.0 - a2) + a2);
  float lambda_l = NoV * sqrt(NoL * NoL * (1.0 - a2) + a2);
  return 0.5 / (lambda_v + lambda_l);
}

// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
vec3 F_Schlick(float VoH, vec3 f0, vec3 f90) {
  float m = clamp(1.0 - VoH, 0.0, 1.0);
  float m2 = m * m;
  return f0 + (f90 - f0) * (m2 * m2 * m);
}

float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Turquin 2019, "Practical Multiple Scattering Compensation for Microfacet Models": the single-scatter lobe is scaled so
// that F0 = 1 reflects everything. `dfg` = (scale, bias) of the split sum (Karis 2013, "Real Shading in Unreal Engine 4").
vec3 multiple_scattering(vec3 f0, vec2 dfg) {
  float e = dfg.x + dfg.y;
  return 1.0 + f0 * ((1.0 - e) / max(e, MIN_COSINE));
}

// `f90`: of a grazing reflection.
vec3 specular_albedo(vec3 f0, vec3 f90, vec2 dfg) { return (f0 * dfg.x + f90 * dfg.y) * multiple_scattering(f0, dfg); }

// Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering": occlusion of a specular lobe from a
// diffuse occlusion.
float specular_occlusion(float NoV, float occlusion, float alpha) {
  return clamp(pow(NoV + occlusion, exp2(-16.0 * alpha - 1.0)) - 1.0 + occlusion, 0.0, 1.0);
}

// Tokuyoshi and Kaplanyan 2019, "Improved Geometric Specular Antialiasing": alpha^2 widened by the variance of the normal
// over the pixel. `change2`: squared change of the unit normal a pixel to the right and one down, summed. `footprint` scales the pixel: 1 / sqrt(sub-frames), so that more samples converge to the true lobe.
float antialiased_alpha(float change2, float alpha, float footprint) {
  const float sigma2 = 0.15915494;  // of the pixel filter: 1 / (2 pi)
  const float kappa = 0.18;         // their clamping threshold
  float variance = sigma2 * footprint * footprint * change2;
  return sqrt(clamp(alpha * alpha + min(2.0 * variance, kappa), 0.0, 1.0));
}
