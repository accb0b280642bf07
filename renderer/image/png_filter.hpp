// The five row filters of PNG (second edition, section 9), both ways.
#pragma once

#include <cstddef>
#include <cstdint>

namespace furnace {

enum class PngFilter : std::uint8_t { kNone, kSub, kUp, kAverage, kPaeth };

// `above` is the row before (zeros above the first); `step` is the distance in bytes to the same sample of the pixel to the
// left. `out` may not overlap the rows.
void png_filter(PngFilter filter, const std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                std::size_t step, std::uint8_t* out);

// Undoes `filter` in place; `above` is undone already.
void png_unfilter(PngFilter filter, std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                  std::size_t step);

}  // namespace furnace
