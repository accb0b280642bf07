// Surface -> radiance towards the viewer.
#include "surface/inputs.glsl"
#include "surface/directional_lights.glsl"
#include "surface/environment_light.glsl"

vec3 surface_radiance(Surface s) {
#if FEATURE_UNLIT
  return s.base_color.rgb;
#else
  vec3 radiance = s.emissive + environment_light(s.base_color.rgb, s.metallic, s.alpha, s.occlusion, s.normal,
                                                 s.to_viewer, s.NoV);
#if FEATURE_LIGHTS
  radiance += directional_lights(s.base_color.rgb, s.metallic, s.alpha, s.normal, s.to_viewer, s.NoV);
#endif
  return radiance;
#endif
}
