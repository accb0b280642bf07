// One triangle over the whole viewport.
#include "interface/frame_block.glsl"

#if FEATURE_SKY || FEATURE_GROUND_SHADOW
layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };
#endif
#if FEATURE_SKY
layout(location = 0) out vec3 sky_ray;
layout(location = 1) flat out vec2 sky;
#if FEATURE_GROUND_PROJECTION
layout(location = 2) out vec3 sky_origin;
layout(location = 3) flat out vec2 dome;
#endif
#else
layout(location = 0) out float from_top;
#endif
#if FEATURE_GROUND_SHADOW
layout(location = 4) out vec3 ground_at;
layout(location = 5) flat out float shadow_strength;
#endif

void main() {
  vec2 ndc = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
#if FEATURE_SKY
  sky_ray = mat3(frame.background_from_world) * (mat3(frame.world_from_ray) * vec3(ndc, 1.0));
  sky = vec2(frame.background_gain, frame.background_lod);
#if FEATURE_GROUND_PROJECTION
  sky_origin = mat3(frame.background_from_world) * (mat3(frame.origin_from_ndc) * vec3(ndc, 1.0));
  dome = vec2(frame.dome_radius, frame.dome_height);
#endif
#else
  from_top = 0.5 - 0.5 * ndc.y;
#endif
#if FEATURE_GROUND_SHADOW
  ground_at = mat3(frame.ground_from_ndc) * vec3(ndc, 1.0);
  shadow_strength = frame.shadow_strength;
#endif
  gl_Position = vec4(ndc, 0.0, 1.0);
}
