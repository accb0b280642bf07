// Transfer functions and luminance; the judges of shaders/lib/color.glsl share these definitions.
#pragma once

#include <cmath>

namespace furnace {

// IEC 61966-2-1:1999, sRGB. Arguments and results in [0, 1].
inline double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
inline double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// ITU-R BT.709: relative luminance of linear Rec.709 RGB.
inline double luminance_rec709(double r, double g, double b) {
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

}  // namespace furnace
