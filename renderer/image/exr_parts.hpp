// Several named pictures and their text in one OpenEXR file: how we keep our own results between runs, readable by any
// viewer. Foreign pictures are read by decode_environment.
#pragma once

#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct NamedImage {
  std::string_view name;  // unique in its file
  const Image* image;     // RGBA, kFloat16; outlives the call
};

struct ExrParts {
  std::map<std::string, Image, std::less<>> images;  // by name: RGBA, kFloat16, kLinear
  std::map<std::string, std::string, std::less<>>
      attributes;  // texts of the first part, but its name and type
};

// Lossless, uncompressed; `attributes` stand in the first part's header, names of at most 255 bytes, values of any bytes.
// Errors: kInternal when the codec refuses. Threads: any.
std::string encode_exr_parts(std::span<const NamedImage> parts, const std::vector<TextField>& attributes);

// What encode_exr_parts wrote, bit for bit; allocates no more than about the size of `file`, whatever that claims.
// Errors: kUnsupportedMedia, kTooLarge, kUnprocessable (anything that encode_exr_parts does not write). Threads: any.
ExrParts decode_exr_parts(std::span<const std::byte> file, const DecodeLimits& limits);

}  // namespace furnace
