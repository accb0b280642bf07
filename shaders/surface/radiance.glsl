// Surface -> radiance towards the viewer, or what a film layer shows in its place.
#include "surface/inputs.glsl"
#include "surface/film_layer.glsl"
#include "surface/environment_light.glsl"
#if FEATURE_LIGHTS
#include "surface/lights.glsl"
#endif
#if FEATURE_SURFACE_VALUE
#include "surface/surface_value.glsl"
#endif
#if FEATURE_LIGHT_PART
#include "surface/light_parts.glsl"
#endif
#if FEATURE_LIGHT_TERM
#include "surface/light_terms.glsl"
#endif

// xyz: radiance, premultiplied by w: opacity, 1 but where a transparent background is seen through the surface.
vec4 surface_radiance(Attributes a, Surface s) {
#if FEATURE_EMISSION && FEATURE_UNLIT
  return vec4(0.0, 0.0, 0.0, 1.0);
#elif FEATURE_EMISSION
  return vec4(s.emissive, 1.0);
#elif FEATURE_SURFACE_VALUE
  return vec4(surface_value(a, s), 1.0);
#elif FEATURE_LIGHT_TERM
  return vec4(light_term(s), 1.0);
#elif FEATURE_LIGHT_PART && FEATURE_UNLIT
  return vec4(s.base_color.rgb * other_share.z, 1.0);
#elif FEATURE_LIGHT_PART
  Leaving light = dark();
  add_shown(environment_light(s), environment_share, light);
#if FEATURE_LIGHTS
  Leaving direct = dark();
  add_direct_light(s, direct);
  add_shown(direct, light_share, light);
#endif
  s.emissive *= other_share.y;
  return layered(s, light);
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
