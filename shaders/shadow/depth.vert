// Triangles as a light sees them.
#include "interface/draw_block.glsl"

layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };
layout(location = 0) uniform mat4 clip_from_world;

layout(location = 0) in vec3 position_model;

#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
layout(location = 3) in vec4 uv01_model;
layout(location = 5) in vec4 color;
layout(location = 0) out vec4 uv01;
layout(location = 1) out float vertex_alpha;
#endif

void main() {
#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
  uv01 = uv01_model;
  vertex_alpha = color.a;
#endif
  gl_Position = clip_from_world * (draw.world_from_model * vec4(position_model, 1.0));
}
