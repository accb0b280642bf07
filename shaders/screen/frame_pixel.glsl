// A pixel of the frame: the mean of its samples.
#if FEATURE_MULTISAMPLED
layout(binding = 0) uniform sampler2DMS frame_map;

vec4 frame_pixel(ivec2 at) {
  return 0.25 * (texelFetch(frame_map, at, 0) + texelFetch(frame_map, at, 1) + texelFetch(frame_map, at, 2) +
                 texelFetch(frame_map, at, 3));
}
#else
layout(binding = 0) uniform sampler2D frame_map;

vec4 frame_pixel(ivec2 at) { return texelFetch(frame_map, at, 0); }
#endif
