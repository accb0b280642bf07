#include "renderer/image/png_filter.hpp"

#include <array>
#include <cstdlib>

namespace furnace {

namespace {

int paeth(int left, int above, int above_left) {
  const int to_left = std::abs(above - above_left);
  const int to_above = std::abs(left - above_left);
  const int to_corner = std::abs(left + above - 2 * above_left);
  const int nearer = to_above <= to_corner ? above : above_left;
  return to_left <= to_above && to_left <= to_corner ? left : nearer;
}

// A Step known to the compiler keeps the pixel to the left in registers.
template <std::size_t Step>
void unfilter(PngFilter filter, std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  std::array<int, Step> left{};
  std::array<int, Step> above_left{};
  const auto each = [&](auto&& predict) {
    for (std::size_t i = 0; i < size; i += Step) {
      for (std::size_t c = 0; c < Step; ++c) {
        const int up = above[i + c];
        left[c] = (row[i + c] + predict(left[c], up, above_left[c])) & 255;
        above_left[c] = up;
        row[i + c] = static_cast<std::uint8_t>(left[c]);
      }
    }
  };
  switch (filter) {
    case PngFilter::kSub:
      return each([](int a, int, int) { return a; });
    case PngFilter::kAverage:
      return each([](int a, int b, int) { return (a + b) / 2; });
    case PngFilter::kPaeth:
      return each([](int a, int b, int c) { return paeth(a, b, c); });
    default:
      return;
  }
}

}  // namespace

void png_unfilter(PngFilter filter, std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                  std::size_t step) {
  if (filter == PngFilter::kNone) return;
  if (filter == PngFilter::kUp) {
    for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
    return;
  }
  switch (step) {
    case 1:
      return unfilter<1>(filter, row, above, size);
    case 2:
      return unfilter<2>(filter, row, above, size);
    case 3:
      return unfilter<3>(filter, row, above, size);
    case 4:
      return unfilter<4>(filter, row, above, size);
    case 6:
      return unfilter<6>(filter, row, above, size);
    case 8:
      return unfilter<8>(filter, row, above, size);
    default:
      return;
  }
}

}  // namespace furnace
