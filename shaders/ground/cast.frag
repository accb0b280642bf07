// Sets the light's bit; the target collects them by a logical OR.
#include "interface/draw_block.glsl"

layout(location = 0) flat in uint light;
layout(location = 1) flat in float least_opacity;
layout(location = 0) out uvec4 out_lights;

#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
#include "surface/material.glsl"
layout(location = 2) in vec4 uv01;
layout(location = 3) in float vertex_alpha;
#endif

void main() {
#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
  float alpha = material.base_color.a * vertex_alpha;
#if FEATURE_MATERIAL_MAPS
  alpha *= texture(base_color_map, slot_uv(SLOT_BASE_COLOR, uv01)).a;
#endif
#if FEATURE_ALPHA_MASK
  if (alpha < material.alpha_cutoff) discard;
  alpha = 1.0;
#endif
#if FEATURE_ALPHA_BLEND
  // Enderton et al. 2010, "Stochastic Transparency": so many of the lights are kept out as the surface is opaque.
  if (alpha * material.shadow_opacity <= least_opacity) discard;
#endif
#endif
  uint bit = 1u << (light & 31u);
  uvec4 word = uvec4(equal(uvec4(light >> 5u), uvec4(0u, 1u, 2u, 3u)));
  out_lights = word * bit;
}
