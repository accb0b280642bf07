// Surface -> radiance towards the viewer.
#include "surface/inputs.glsl"
#include "surface/environment_light.glsl"

vec3 surface_radiance(Surface s) {
#if FEATURE_UNLIT
  return s.base_color.rgb;
#else
  return s.emissive +
         environment_light(s.base_color.rgb, s.metallic, s.alpha, s.occlusion, s.normal, s.to_viewer, s.NoV);
#endif
}
