// One triangle over the whole viewport.
#include "interface/frame_block.glsl"

#if FEATURE_SKY
layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };
layout(location = 0) out vec3 sky_ray;
layout(location = 1) flat out vec2 sky;
#endif

void main() {
  vec2 ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
#if FEATURE_SKY
  sky_ray = mat3(frame.environment_from_world) * (mat3(frame.world_from_ray) * vec3(ndc, 1.0));
  sky = vec2(frame.sky_gain, frame.sky_lod);
#endif
  gl_Position = vec4(ndc, 0.0, 1.0);
}
