// The ICC profile that says in a file what sRGB is.
#pragma once

#include <string>

namespace furnace {

// Version 4, display class, RGB to XYZ: primaries, white and transfer function of IEC 61966-2-1:1999. Same bytes each time.
std::string srgb_icc_profile();

}  // namespace furnace
