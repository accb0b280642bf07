// One triangle over the viewport, at the depth that stands for the draw.
#include "interface/draw_block.glsl"
#include "lib/visibility.glsl"
#include "surface/deferred_constants.glsl"
#include "surface/write_constants.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };
layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };

layout(location = 0) out vec2 ndc;
layout(location = 1) out vec3 to_viewer_world;
layout(location = 2) flat out SurfaceConstants constants;
layout(location = 11) flat out DeferredConstants deferred;

void main() {
  ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  to_viewer_world = frame.eye_world.w > 0.5 ? -mat3(frame.world_from_ray) * vec3(ndc, 1.0) : frame.towards_viewer_world.xyz;
  constants = surface_constants(frame);
  mat4 rows = transpose(frame.clip_from_world * draw.world_from_model);
  deferred = DeferredConstants(rows[0], rows[1], rows[3], mat3(draw.world_from_model_normal), mat3(draw.world_from_model),
                               draw.world_from_model[3], vec4(draw.handedness, frame.ndc_per_pixel_x, frame.ndc_per_pixel_y,
                                    pow(abs(determinant(mat3(draw.world_from_model))), 1.0 / 3.0)),
                               uvec2(draw.key, draw.vertex_rows));
  gl_Position = vec4(ndc, depth_of_key(draw.key), 1.0);
}
