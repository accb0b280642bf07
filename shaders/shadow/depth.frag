#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
#include "surface/material.glsl"
layout(location = 0) in vec4 uv01;
layout(location = 1) in float vertex_alpha;
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
  // Enderton et al. 2010, "Stochastic Transparency", with the fixed thresholds of Bayer 1973, "An optimum method for
  // two-level rendition": of 4 x 4 texels so many are kept as the surface is opaque.
  uvec2 at = uvec2(gl_FragCoord.xy);
  uvec2 low = at & 1u, high = at >> 1u & 1u;
  uint rank = 4u * (2u * (low.x ^ low.y) + low.y) + 2u * (high.x ^ high.y) + high.y;
  if (alpha * material.shadow_opacity * 16.0 <= float(rank) + 0.5) discard;
#endif
#endif
}
