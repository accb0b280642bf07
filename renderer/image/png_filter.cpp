#include "renderer/image/png_filter.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace furnace {

namespace {

// Room for sums and signs of bytes. GCC and Clang make vector instructions of Lanes on every processor.
using Sample = std::int16_t;
using Lanes [[gnu::vector_size(16)]] = Sample;
using Bytes [[gnu::vector_size(8)]] = std::uint8_t;

template <class T>
T smaller(T a, T b) {
  return a < b ? a : b;
}
template <class T>
T magnitude(T value) {
  const T negative = static_cast<T>(-value);
  return value < negative ? negative : value;
}

// The neighbour that is nearest to left + above - above_left; in case of doubt in this order. T is Sample or Lanes.
template <class T>
T paeth(T left, T above, T above_left) {
  const T from_left = static_cast<T>(above - above_left), from_above = static_cast<T>(left - above_left);
  const T to_left = magnitude(from_left), to_above = magnitude(from_above);
  const T to_corner = magnitude(static_cast<T>(from_left + from_above));
  const T nearer = to_above < to_left ? above : left;
  return to_corner < smaller(to_above, to_left) ? above_left : nearer;
}

// A pixel, put together in a register: on the way through memory the processor would have to wait.
template <std::size_t Size>
Lanes load(const std::uint8_t* from) {
  std::uint64_t bits = 0;
  std::size_t at = 0;
  const auto take = [&](auto part) {
    if ((Size & sizeof(part)) == 0) return;
    std::memcpy(&part, from + at, sizeof(part));
    bits |= std::uint64_t{part} << (8 * at % 64);
    at += sizeof(part);
  };
  take(std::uint64_t{});
  take(std::uint32_t{});
  take(std::uint16_t{});
  take(std::uint8_t{});
  return __builtin_convertvector(std::bit_cast<Bytes>(bits), Lanes);
}

template <std::size_t Size>
void store(Lanes lanes, std::uint8_t* to) {
  const auto bits = std::bit_cast<std::uint64_t>(__builtin_convertvector(lanes, Bytes));
  std::size_t at = 0;
  const auto put = [&](auto part) {
    if ((Size & sizeof(part)) == 0) return;
    part = static_cast<decltype(part)>(bits >> (8 * at % 64));
    std::memcpy(to + at, &part, sizeof(part));
    at += sizeof(part);
  };
  put(std::uint64_t{});
  put(std::uint32_t{});
  put(std::uint16_t{});
  put(std::uint8_t{});
}

// Each pixel waits for the one before; its samples are done together.
template <std::size_t Step>
void unfilter_paeth(std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  Lanes left{}, above_left{};
  for (std::size_t i = 0; i < size; i += Step) {
    const Lanes up = load<Step>(above + i);
    left = (load<Step>(row + i) + paeth(left, up, above_left)) & 255;
    above_left = up;
    store<Step>(left, row + i);
  }
}

// A Step known to the compiler keeps the pixel to the left in registers.
template <std::size_t Step>
void unfilter(PngFilter filter, std::uint8_t* row, const std::uint8_t* above, std::size_t size) {
  if (filter == PngFilter::kPaeth) return unfilter_paeth<Step>(row, above, size);
  std::array<int, Step> left{};
  const auto each = [&](auto&& predict) {
    for (std::size_t i = 0; i < size; i += Step) {
      for (std::size_t c = 0; c < Step; ++c) {
        left[c] = (row[i + c] + predict(left[c], above[i + c])) & 255;
        row[i + c] = static_cast<std::uint8_t>(left[c]);
      }
    }
  };
  if (filter == PngFilter::kAverage) return each([](int a, int b) { return (a + b) / 2; });
  each([](int a, int) { return a; });
}

// Unlike its inverse nothing here waits for the pixel before: the compiler makes vectors of it.
template <class Predict>
void filter_row(const std::uint8_t* __restrict row, const std::uint8_t* __restrict above, std::size_t size,
                std::size_t step, std::uint8_t* __restrict out, Predict&& predict) {
  for (std::size_t i = 0; i < std::min(step, size); ++i) {
    out[i] = static_cast<std::uint8_t>(row[i] - predict(Sample{0}, Sample{above[i]}, Sample{0}));
  }
  for (std::size_t i = step; i < size; ++i) {
    out[i] = static_cast<std::uint8_t>(
        row[i] - predict(Sample{row[i - step]}, Sample{above[i]}, Sample{above[i - step]}));
  }
}

}  // namespace

void png_filter(PngFilter filter, const std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                std::size_t step, std::uint8_t* out) {
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
