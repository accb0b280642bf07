// What the first bytes of a texture file say, by own readers that decode nothing: for reports, which look at files
// that nobody vouches for in the process that serves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace furnace {

struct ImageHeader {
  std::string_view format;  // "PNG", "JPEG", "WebP", "KTX2", "AVIF"
  // px; 0: the header does not say, or is damaged
  std::uint32_t width = 0, height = 0;
  int channels = 0;  // as decoded: 1 to 4; 0: not said
  int bits = 0;      // of a sample as decoded: 8 or 16; 0: not said

  bool is_complete() const { return width > 0 && height > 0; }
};

// None for what is none of these formats. Looks at a bounded number of its parts. Threads: any.
std::optional<ImageHeader> read_image_header(std::span<const std::byte> file);

}  // namespace furnace
