// The bits of the lights that do not reach the ground here -> minus their share of all far light.
#include "interface/ground_block.glsl"

layout(std140, binding = 3) uniform GroundUniform { GroundBlock ground; };
layout(binding = 0) uniform usampler2D lights_map;
layout(location = 0) out vec4 out_change;

void main() {
  uvec4 lights = texelFetch(lights_map, ivec2(gl_FragCoord.xy), 0);
  vec3 missing = vec3(0.0);
  for (uint word = 0u; word < 4u; ++word) {
    uint bits = lights[word];
    if (bits == 0u) continue;
    for (uint i = 0u; i < 32u; ++i) missing += float(bits >> i & 1u) * ground.weight[32u * word + i].xyz;
  }
  out_change = vec4(-missing, 0.0);
}
