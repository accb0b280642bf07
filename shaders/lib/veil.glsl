// A pixel of the veil: what is drawn before the visible. Four numbers:
//   x, y: its mean colour and opacity over the pixel's four samples, premultiplied, exposed; halves
//   z, w: how much of the light behind each sample passes; 16 bits each
#include "lib/visibility.glsl"

uvec4 veil_pixel(vec4 mean, vec4 passing) {
  return uvec4(packHalf2x16(mean.rg), packHalf2x16(mean.ba), packUnorm2x16(passing.xy), packUnorm2x16(passing.zw));
}

vec4 veil_mean(uvec4 pixel) { return vec4(unpackHalf2x16(pixel.x), unpackHalf2x16(pixel.y)); }
vec4 veil_passing(uvec4 pixel) { return vec4(unpackUnorm2x16(pixel.z), unpackUnorm2x16(pixel.w)); }
