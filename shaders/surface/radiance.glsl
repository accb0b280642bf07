// Surface -> radiance towards the viewer.
#include "surface/inputs.glsl"
#include "surface/environment_light.glsl"
#if FEATURE_LIGHTS
#include "surface/lights.glsl"
#endif

vec3 surface_radiance(Surface s) {
#if FEATURE_EMISSION && FEATURE_UNLIT
  return vec3(0.0);
#elif FEATURE_EMISSION
  return s.emissive;
#elif FEATURE_UNLIT
  return s.base_color.rgb;
#else
  vec3 radiance = s.emissive + environment_light(s.base_color.rgb, s.metallic, s.alpha, s.occlusion, s.normal,
                                                 s.to_viewer, s.NoV);
#if FEATURE_LIGHTS
  radiance += direct_light(s.base_color.rgb, s.metallic, s.alpha, s.position, s.normal, s.to_viewer, s.NoV);
#endif
  return radiance;
#endif
}
