// Surface -> radiance towards the viewer.
#include "surface/inputs.glsl"
#include "surface/environment_light.glsl"
#if FEATURE_SKY_VISIBILITY
#include "surface/environment_visibility.glsl"
#endif
#if FEATURE_LIGHTS
#include "surface/lights.glsl"
#endif

vec3 surface_radiance(Surface s) {
#if FEATURE_UNLIT
  return s.base_color.rgb;
#else
#if FEATURE_SKY_VISIBILITY
  const float occlusion = 1.0;  // as path tracers do: a map of it would darken again
#else
  float occlusion = s.occlusion;
#endif
  vec3 radiance = s.emissive + environment_light(s.base_color.rgb, s.metallic, s.alpha, occlusion, s.normal,
                                                 s.to_viewer, s.NoV);
#if FEATURE_SKY_VISIBILITY
  radiance -= hidden_environment_light(s.base_color.rgb, s.metallic, s.alpha, s.position, s.smooth_normal, s.normal,
                                       s.to_viewer, s.NoV);
#endif
#if FEATURE_LIGHTS
  radiance += direct_light(s.base_color.rgb, s.metallic, s.alpha, s.position, s.normal, s.to_viewer, s.NoV);
#endif
  return radiance;
#endif
}
