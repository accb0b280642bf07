// Writes, where sample `layer` is to be shaded, the depth that stands for its draw; 0 elsewhere.
#include "lib/visibility.glsl"

layout(binding = 0) uniform usampler2D visibility_map;
layout(binding = 1) uniform usampler2D shares_map;

layout(location = 0) uniform uint layer;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  bool shaded = shaded_by(texelFetch(shares_map, pixel, 0).x, layer) == layer;
  uint texel_y = texelFetch(visibility_map, sample_at(pixel, layer), 0).y;
  gl_FragDepth = shaded ? depth_of_key(key_of(texel_y)) : 0.0;
}
