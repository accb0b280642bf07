// One instance a light: each triangle, moved along the light onto the ground.
#include "interface/draw_block.glsl"
#include "interface/ground_block.glsl"

layout(std140, binding = 1) uniform DrawUniform { DrawBlock draw; };
layout(std140, binding = 3) uniform GroundUniform { GroundBlock ground; };

layout(location = 0) in vec3 position_model;
layout(location = 0) flat out uint light;
layout(location = 1) flat out float least_opacity;

#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
layout(location = 3) in vec4 uv01_model;
layout(location = 5) in vec4 color;
layout(location = 2) out vec4 uv01;
layout(location = 3) out float vertex_alpha;
#endif

void main() {
  vec4 position = draw.world_from_model * vec4(position_model, 1.0);
  vec4 towards = ground.light[gl_InstanceID];
  // What lies below the ground casts nothing beyond its own place; what lies above a lamp has w < 0 and is clipped.
  float height = max(position.y - ground.level, 0.0);
  vec2 at = position.xz - towards.xy * height;
  float w = 1.0 - towards.z * height;
  light = uint(gl_InstanceID);
  least_opacity = towards.w;
#if FEATURE_ALPHA_MASK || FEATURE_ALPHA_BLEND
  uv01 = uv01_model;
  vertex_alpha = color.a;
#endif
  // Within a texel, each light its own way: hard shadows of a sun have smooth edges.
  vec2 middle = ground.clip_from_ground.zw + ground.shift[gl_InstanceID].xy;
  gl_Position = vec4(at * ground.clip_from_ground.xy + middle * w, 0.5 * w, w);
}
