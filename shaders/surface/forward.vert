// Blended surfaces, lines and points: shaded where they are drawn.
#include "interface/draw_block.glsl"
#include "surface/needs.glsl"
#include "surface/tangent_frame.glsl"
#include "surface/write_constants.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };
layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };

layout(location = 0) in vec3 position_model;
layout(location = 1) in vec3 normal_model;
layout(location = 2) in vec4 tangent_model;
layout(location = 3) in vec4 uv01_model;
layout(location = 5) in vec4 color;

layout(location = 0) out vec3 to_viewer_world;
layout(location = 1) out vec3 normal_world;
layout(location = 2) out vec4 tangent_world;
layout(location = 3) out vec4 uv01;
layout(location = 4) out vec4 vertex_color;
layout(location = 5) flat out SurfaceConstants constants;
#if NEEDS_POSITION
layout(location = 14) out vec3 position_world;
#endif

void main() {
  vec4 world = draw.world_from_model * vec4(position_model, 1.0);
  to_viewer_world = frame.eye_world.w > 0.5 ? frame.eye_world.xyz - world.xyz : frame.towards_viewer_world.xyz;
#if NEEDS_POSITION
  position_world = world.xyz;
#endif
  normal_world = with_length_of(normal_model, mat3(draw.world_from_model_normal) * normal_model);
#if NEEDS_TANGENT
  tangent_world = vec4(with_length_of(tangent_model.xyz, mat3(draw.world_from_model) * tangent_model.xyz),
                       tangent_model.w * draw.handedness);
#else
  tangent_world = vec4(0.0);
#endif
  constants = surface_constants(frame);
  uv01 = uv01_model;
  vertex_color = color;
  gl_PointSize = frame.point_size_samples;
  gl_Position = frame.clip_from_world * world;
}
