#include "interface/draw_block.glsl"
#include "interface/frame_block.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };
layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };

layout(location = 0) in vec3 position_model;
layout(location = 1) in vec3 normal_model;
layout(location = 6) in uint vertex_patch;
layout(location = 0) flat out uint surface_patch;
layout(location = 3) out vec3 normal_of_model;

#if FEATURE_ALPHA_MASK
layout(location = 3) in vec4 uv01_model;
layout(location = 5) in vec4 color;
layout(location = 1) out vec4 uv01;
layout(location = 2) out float vertex_alpha;
#endif

void main() {
  surface_patch = vertex_patch;
  normal_of_model = normal_model;
#if FEATURE_ALPHA_MASK
  uv01 = uv01_model;
  vertex_alpha = color.a;
#endif
  gl_Position = frame.clip_from_world * (draw.world_from_model * vec4(position_model, 1.0));
}
