// Lobes of layers and of older models.
#include "lib/brdf.glsl"

// Burley 2012, "Physically Based Shading at Disney": GGX of other widths along tangent and bitangent; cosines of the half
// vector. Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs": its Smith term.
float D_GGX_anisotropic(float NoH, float ToH, float BoH, float alpha_t, float alpha_b) {
  float a2 = alpha_t * alpha_b;
  vec3 d = vec3(alpha_b * ToH, alpha_t * BoH, a2 * NoH);
  float w = a2 / dot(d, d);
  return a2 * w * w * INV_PI;
}

float V_SmithGGXAnisotropic(float NoV, float NoL, float ToV, float BoV, float ToL, float BoL, float alpha_t, float alpha_b) {
  float lambda_v = NoL * length(vec3(alpha_t * ToV, alpha_b * BoV, NoV));
  float lambda_l = NoV * length(vec3(alpha_t * ToL, alpha_b * BoL, NoL));
  return 0.5 / max(lambda_v + lambda_l, 1e-7);
}

// Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF".
float D_Charlie(float NoH, float alpha) {
  float sine2 = max(1.0 - NoH * NoH, 1e-7);
  return (2.0 + 1.0 / alpha) * pow(sine2, 0.5 / alpha) / TWO_PI;
}

float charlie_lambda_fit(float x, float alpha) {
  float smooth_share = (1.0 - alpha) * (1.0 - alpha);
  float a = mix(21.5473, 25.3245, smooth_share);
  float b = mix(3.82987, 3.32435, smooth_share);
  float c = mix(0.19823, 0.16801, smooth_share);
  float d = mix(-1.97760, -1.27393, smooth_share);
  float e = mix(-4.32054, -4.85967, smooth_share);
  return a / (1.0 + b * pow(x, c)) + d * x + e;
}

float charlie_lambda(float cosine, float alpha) {
  cosine = clamp(cosine, MIN_COSINE, 1.0 - MIN_COSINE);
  return exp(cosine < 0.5 ? charlie_lambda_fit(cosine, alpha)
                          : 2.0 * charlie_lambda_fit(0.5, alpha) - charlie_lambda_fit(1.0 - cosine, alpha));
}

float V_Charlie(float NoV, float NoL, float alpha) {
  return 1.0 / ((1.0 + charlie_lambda(NoV, alpha) + charlie_lambda(NoL, alpha)) * 4.0 * NoV * NoL);
}

// How far the mean direction of that lobe lies from the normal, on the viewer's side (rad): fitted to its first moment, which has
// 9 to 14 degrees at roughness 1 and 55 to 78 at 0.2.
float charlie_lean(float perceptual_roughness) { return 0.5 * PI * exp(-1.9 * perceptual_roughness); }

// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering", with the k of Karis 2013, "Real Shading in
// Unreal Engine 4", for lights: V = G / (4 NoL NoV).
float V_SchlickBeckmann(float NoV, float NoL, float perceptual_roughness) {
  float r = perceptual_roughness + 1.0;
  float k = r * r / 8.0;
  return 0.25 / ((NoV * (1.0 - k) + k) * (NoL * (1.0 - k) + k));
}

// Karis 2014, "Physically Based Shading on Mobile": scale and bias of the split sum of that model, fitted.
vec2 schlick_beckmann_dfg(float NoV, float perceptual_roughness) {
  vec4 r = perceptual_roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a = min(r.x * r.x, exp2(-9.28 * NoV)) * r.x + r.y;
  return vec2(-1.04, 1.04) * a + r.zw;
}

// Blinn's exponent whose lobe is as wide as a microfacet distribution of this alpha (Walter 2007, "Microfacet Models for
// Refraction through Rough Surfaces"); Phong's measures twice the angle and has a quarter of it.
float blinn_exponent(float alpha) { return 2.0 / max(alpha * alpha, 1e-4) - 2.0; }

// Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures", and Phong 1975, "Illumination for Computer
// Generated Pictures", normalised as in Akenine-Moller, Haines and Hoffman 2008, "Real-Time Rendering", 3rd edition, and in
// Lafortune and Willems 1994, "Using the Modified Phong Reflectance Model for Physically Based Rendering".
float blinn_phong_lobe(float NoH, float alpha) {
  float s = blinn_exponent(alpha);
  return (s + 8.0) / (8.0 * PI) * pow(max(NoH, 0.0), s);
}

float phong_lobe(float RoV, float alpha) {
  float s = 0.25 * blinn_exponent(alpha);
  return (s + 2.0) / TWO_PI * pow(max(RoV, 0.0), s);
}
