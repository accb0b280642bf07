// Which of a pixel's four samples are shaded: one for each surface, since shading hardly varies over one surface within a
// pixel (Ragan-Kelley et al. 2011, "Decoupled Sampling for Graphics Pipelines"). Selects layer 0 too, as
// select.frag does the others.
#include "interface/frame_block.glsl"
#include "lib/visibility.glsl"

layout(std140, binding = 0) uniform FrameUniform { FrameBlock frame; };

layout(binding = 0) uniform usampler2D visibility_map;
layout(binding = 1) uniform sampler2D depth_map;

layout(location = 0) out uint out_shares;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec2 between = vec2(2 * pixel + 1) / vec2(textureSize(visibility_map, 0));
  // A gather goes round from the lower left: in the order of sample_at().
  uvec4 texel_x = textureGather(visibility_map, between, 0).wzxy;
  uvec4 texel_y = textureGather(visibility_map, between, 1).wzxy;
  vec4 depth = textureGather(depth_map, between).wzxy;
  uint shares = 0u;
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) {
    uint by = i;
    // Downwards: the lowest that fits remains. Only one that is shaded itself can be shared.
    for (uint j = i; j-- > 0u;) {
      // The same patch may come twice, one part of it before another.
      bool is_one = is_one_surface(uvec2(texel_x[i], texel_y[i]), uvec2(texel_x[j], texel_y[j]));
      if (is_one && shaded_by(shares, j) == j && abs(depth[i] - depth[j]) <= frame.depth_tolerance * max(depth[i], depth[j])) by = j;
    }
    shares |= (texel_y[i] == 0u ? NO_SAMPLE : by) << 3u * i;
  }
#if FEATURE_NEAREST
  // Depth is reversed. A pixel of that surface alone keeps its shares, and is shaded at its centre.
  uint nearest = 0u;
  for (uint i = 1u; i < SAMPLE_COUNT; ++i) nearest = depth[i] > depth[nearest] ? i : nearest;
  uint by = shaded_by(shares, nearest);
  for (uint i = 0u; i < SAMPLE_COUNT; ++i) {
    if (shaded_by(shares, i) != by) shares = shares & ~(7u << 3u * i) | NO_SAMPLE << 3u * i;
  }
#endif
  out_shares = shares;
  gl_FragDepth = depth_of_key(key_of(texel_y[0]));
}
