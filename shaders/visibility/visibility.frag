#include "interface/draw_block.glsl"
#include "lib/visibility.glsl"

layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };

layout(location = 0) flat in uint surface_patch;
layout(location = 3) in vec3 normal_of_model;
layout(location = 0) out uvec2 out_texel;

#if FEATURE_ALPHA_MASK
#include "surface/material.glsl"
layout(location = 1) in vec4 uv01;
layout(location = 2) in float vertex_alpha;
#endif

void main() {
#if FEATURE_ALPHA_MASK
  // Every sample decides for itself: the edge of a mask is as smooth as that of a triangle.
  float alpha = material.base_color.a * vertex_alpha;
#if FEATURE_MATERIAL_MAPS
  alpha *= texture(base_color_map, slot_uv(SLOT_BASE_COLOR, uv01)).a;
#endif
  if (alpha < material.alpha_cutoff) discard;
#endif
  out_texel = visibility_texel(uint(gl_PrimitiveID), surface_patch, draw.key, normal_of_model);
}
