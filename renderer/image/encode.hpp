// Images -> file bytes in memory. Same image, same bytes.
#pragma once

#include "renderer/image/image.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct TextField {
  std::string key;
  std::string value;
};

// 8-bit sRGB, 3 or 4 channels (straight alpha), tagged sRGB. Settings were chosen by bench: encoding must
// cost less than drawing the picture did. Errors: kInternal when the codec refuses. Threads: any.
std::string encode_png(const Image& image, const std::vector<TextField>& metadata);

// Linear RGB(A), alpha premultiplied, channels R G B (A), kFloat16 or kFloat32 as the image's type says.
std::string encode_exr(const Image& image, const std::vector<TextField>& metadata);

}  // namespace furnace
