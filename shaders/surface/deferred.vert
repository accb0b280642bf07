// One triangle over the viewport, at the depth that stands for the draw.
#include "interface/draw_block.glsl"
#include "lib/visibility.glsl"

layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };

layout(location = 0) out vec2 ndc;

void main() {
  ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(ndc, depth_of_key(draw.key), 1.0);
}
