// Light by its parts: what leaves a surface is linear in each of them, so that parts sum to the whole.
#include "surface/environment_light.glsl"
#include "surface/film_layer.glsl"

Leaving dark() {
  Leaving l;
  l.diffuse = l.specular = l.through = l.see_through = vec3(0.0);
#if FEATURE_SHEEN
  l.sheen = vec3(0.0);
#endif
#if FEATURE_CLEARCOAT
  l.clearcoat = vec3(0.0);
#endif
  return l;
}

// What lets a transparent background through is no light, and stays.
void add_shown(Leaving more, vec4 share, inout Leaving sum) {
  sum.diffuse += more.diffuse * share.x;
  sum.specular += more.specular * share.y;
  sum.through += more.through * other_share.x;
  sum.see_through += more.see_through;
#if FEATURE_SHEEN
  sum.sheen += more.sheen * share.z;
#endif
#if FEATURE_CLEARCOAT
  sum.clearcoat += more.clearcoat * share.w;
#endif
}
