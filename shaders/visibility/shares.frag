// Which of a pixel's four samples are shaded: one for each surface, since shading hardly varies over one surface within a
// pixel (Ragan-Kelley et al. 2011, "Decoupled Sampling for Graphics Pipelines").
#include "lib/visibility.glsl"

layout(binding = 0) uniform usampler2D visibility_map;
layout(binding = 1) uniform sampler2D depth_map;

layout(location = 0) uniform float tolerance;  // relative difference of depth within one surface
layout(location = 0) out uint out_shares;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint surface[SAMPLE_COUNT];
  float depth[SAMPLE_COUNT];
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) {
    surface[i] = texelFetch(visibility_map, sample_at(pixel, i), 0).y;
    depth[i] = texelFetch(depth_map, sample_at(pixel, i), 0).r;
  }
  uint shares = 0u;
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) {
    uint by = i;
    // Downwards: the lowest that fits remains.
    for (uint j = i; j-- > 0u;) {
      // The same patch may come twice, one part of it before another.
      if (surface[i] == surface[j] && abs(depth[i] - depth[j]) <= tolerance * max(depth[i], depth[j])) by = j;
    }
    shares |= (surface[i] == 0u ? NO_SAMPLE : by) << 3u * i;
  }
  out_shares = shares;
}
