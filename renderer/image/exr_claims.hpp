// What an OpenEXR file claims to hold, read by ourselves: the library allocates by these numbers before we
// could object.
#pragma once

#include "renderer/image/decode.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace furnace {

struct ExrWindow {
  std::int32_t min_x = 0, min_y = 0, max_x = -1, max_y = -1;  // px, inclusive

  std::int64_t width() const { return std::int64_t{max_x} - min_x + 1; }
  std::int64_t height() const { return std::int64_t{max_y} - min_y + 1; }
};

struct ExrChannel {
  std::string name;
  std::int64_t sample_bytes = 0;
  bool is_subsampled = false;
};

struct ExrPart {
  ExrWindow data_window;
  ExrWindow display_window;
  std::vector<ExrChannel> channels;
  bool is_tiled = false;
  std::uint32_t tile_width = 0, tile_height = 0;  // px
  std::uint8_t tile_mode = 0;                     // levels in the low four bits, rounding above
  std::uint8_t compression = 0;
  bool is_deep = false;

  bool has(std::string_view channel) const;
};

// Parses the headers of all parts and refuses what no honest file claims: windows over the limits, chunks or
// tables of chunks that cannot be in a file of this size. Errors: kTooLarge, kUnsupportedMedia (deep data),
// kUnprocessable.
std::vector<ExrPart> read_exr_claims(std::span<const std::byte> file, const DecodeLimits& limits);

}  // namespace furnace
