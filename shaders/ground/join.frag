// What reaches the ground of far light and of lamps, as a share of what would without the scene.
#include "interface/ground_block.glsl"

layout(std140, binding = 3) uniform GroundUniform { GroundBlock ground; };
layout(binding = 0) uniform sampler2D far_share_map;
layout(binding = 1) uniform sampler2D lamps_map;       // irradiance
layout(binding = 2) uniform sampler2D free_lamps_map;  // the same without the scene
layout(location = 0) out vec4 out_share;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 far = ground.far_light.rgb;
  vec3 lit = far * texelFetch(far_share_map, at, 0).rgb + texelFetch(lamps_map, at, 0).rgb;
  vec3 all = far + texelFetch(free_lamps_map, at, 0).rgb;
  vec3 share = mix(vec3(1.0), lit / max(all, vec3(1e-30)), greaterThan(all, vec3(0.0)));
  out_share = vec4(share, 1.0);
}
