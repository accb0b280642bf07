// One term of the formulae by which a surface is lit, in place of its radiance.
#include "surface/environment_light.glsl"
#include "surface/film_layer.glsl"
#if FEATURE_LIGHTS
#include "surface/lights.glsl"
#endif

// To the middle of the first light; where there is none, to what a mirror would show of the environment.
vec3 first_light_direction(Surface s) {
#if FEATURE_LIGHTS
  vec4 place = lights.lights[0].place;
  vec3 to_light = place.xyz - (place.w > LIGHT_FAR ? s.position : vec3(0.0));
  return to_light * inversesqrt(max(dot(to_light, to_light), 1e-20));
#else
  return reflect(-s.to_viewer, s.normal);
#endif
}

// The microfacet terms of Cook and Torrance 1982, "A Reflectance Model for Computer Graphics", of the material's own model;
// Phong's and Blinn's have neither F nor G beyond a colour and 1.
vec3 microfacet_term(Surface s) {
  vec3 l = first_light_direction(s);
  vec3 h = normalize(l + s.to_viewer);
  float NoH = clamp(dot(s.normal, h), 0.0, 1.0), VoH = clamp(dot(s.to_viewer, h), 0.0, 1.0), NoL = dot(s.normal, l);
  float alpha = max(s.alpha, 1e-4);
  vec3 f0 = mix(s.f0, s.metal_f0, s.metallic), f90 = mix(s.f90, vec3(1.0), s.metallic);
#if FEATURE_PHONG
  if (shown == SHOWN_FRESNEL) return f0;
  if (shown == SHOWN_GEOMETRY) return vec3(1.0);
  return vec3(layers.is_phong != 0u ? phong_lobe(dot(reflect(-l, s.normal), s.to_viewer), alpha) : blinn_phong_lobe(NoH, alpha));
#else
  if (shown == SHOWN_FRESNEL) return F_Schlick(VoH, f0, f90);
  float lit = max(NoL, MIN_COSINE);
#if FEATURE_ANISOTROPY
  vec3 b = cross(s.normal, s.tangent);
  float alpha_t = max(s.alpha_t, 1e-4);
  float D = D_GGX_anisotropic(NoH, dot(s.tangent, h), dot(b, h), alpha_t, alpha);
  float V = V_SmithGGXAnisotropic(s.NoV, lit, dot(s.tangent, s.to_viewer), dot(b, s.to_viewer), dot(s.tangent, l), dot(b, l),
                                  alpha_t, alpha);
#else
  float D = D_GGX(NoH, alpha);
#if FEATURE_SCHLICK_BECKMANN
  float V = V_SchlickBeckmann(s.NoV, lit, sqrt(alpha));
#else
  float V = V_SmithGGXCorrelated(s.NoV, lit, alpha);
#endif
#endif
  if (shown == SHOWN_DISTRIBUTION) return vec3(D);
  return vec3(NoL > 0.0 ? 4.0 * s.NoV * lit * V : 0.0);
#endif
}

vec3 light_term(Surface s) {
  if (shown == SHOWN_IRRADIANCE) return PI * diffuse_radiance(constants.environment_from_world * s.normal);
  if (shown == SHOWN_PREFILTERED) return specular_radiance(s, lobe_lean(s), sqrt(s.alpha));
  return microfacet_term(s);
}
