#include "renderer/image/png_filter.hpp"

#include <algorithm>
#include <array>

namespace furnace {

namespace {

template <class Sample>
Sample paeth(Sample left, Sample above, Sample above_left) {
  const auto distance = [](int a, int b) { return static_cast<Sample>(a < b ? b - a : a - b); };
  const Sample to_left = distance(above, above_left);
  const Sample to_above = distance(left, above_left);
  const Sample to_corner = distance(left + above, 2 * above_left);
  const Sample nearer = to_above <= to_corner ? above : above_left;
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

// Unlike its inverse nothing here waits for the pixel before: the compiler makes vectors of it.
template <class Predict>
void filter_row(const std::uint8_t* __restrict row, const std::uint8_t* __restrict above, std::size_t size,
                std::size_t step, std::uint8_t* __restrict out, Predict&& predict) {
  for (std::size_t i = 0; i < std::min(step, size); ++i) {
    out[i] =
        static_cast<std::uint8_t>(row[i] - predict(std::int16_t{0}, std::int16_t{above[i]}, std::int16_t{0}));
  }
  for (std::size_t i = step; i < size; ++i) {
    out[i] = static_cast<std::uint8_t>(
        row[i] - predict(std::int16_t{row[i - step]}, std::int16_t{above[i]}, std::int16_t{above[i - step]}));
  }
}

}  // namespace

void png_filter(PngFilter filter, const std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                std::size_t step, std::uint8_t* out) {
  using Sample = std::int16_t;  // twice as many fit into a vector as of int
  const auto apply = [&](auto&& predict) { filter_row(row, above, size, step, out, predict); };
  switch (filter) {
    case PngFilter::kNone:
      return apply([](Sample, Sample, Sample) { return Sample{0}; });
    case PngFilter::kSub:
      return apply([](Sample a, Sample, Sample) { return a; });
    case PngFilter::kUp:
      return apply([](Sample, Sample b, Sample) { return b; });
    case PngFilter::kAverage:
      return apply([](Sample a, Sample b, Sample) { return static_cast<Sample>((a + b) / 2); });
    case PngFilter::kPaeth:
      return apply([](Sample a, Sample b, Sample c) { return paeth(a, b, c); });
  }
}

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
