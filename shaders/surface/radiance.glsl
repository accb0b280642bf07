// Surface -> radiance towards the viewer.
#include "surface/inputs.glsl"
#include "surface/environment_light.glsl"
#if FEATURE_LIGHTS
#include "surface/lights.glsl"
#endif

// xyz: radiance, premultiplied by w: opacity, 1 but where a transparent background is seen through the surface.
vec4 surface_radiance(Surface s) {
#if FEATURE_EMISSION && FEATURE_UNLIT
  return vec4(0.0, 0.0, 0.0, 1.0);
#elif FEATURE_EMISSION
  return vec4(s.emissive, 1.0);
#elif FEATURE_UNLIT
  return vec4(s.base_color.rgb, 1.0);
#else
  Leaving light = environment_light(s);
#if FEATURE_LIGHTS
  add_direct_light(s, light);
#endif
  return layered(s, light);
#endif
}
