// The five row filters of PNG (second edition, section 9), both ways.
#pragma once

#include <cstddef>
#include <cstdint>

namespace furnace {

enum class PngFilter : std::uint8_t { kNone, kSub, kUp, kAverage, kPaeth };

// Undoes `filter` in place. `above` is the row before, already undone (zeros above the first); `step` is the
// distance in bytes to the same sample of the pixel to the left.
void png_unfilter(PngFilter filter, std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                  std::size_t step);

}  // namespace furnace
