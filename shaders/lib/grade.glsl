// What is done to exposed linear radiance before the tone curve.
#include "lib/color.glsl"

// ASC 2009, "Color Decision List", with mid grey as the slope's pivot: power, then saturation.
vec3 graded(vec3 c, mat3 white_balance, float contrast, float saturation) {
  const float mid_grey = 0.18;
  const float highest = 1.8e19;  // 2^64: its square is still a number
  c = max(white_balance * c, vec3(0.0));
  c = min(mid_grey * pow(c / mid_grey, vec3(contrast)), vec3(highest));
  return max(mix(vec3(luminance(c)), c, saturation), vec3(0.0));
}
