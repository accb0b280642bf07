// Pixels with their meaning. Row 0 is the top row; rows are tightly packed, channels interleaved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace furnace {

enum class SampleType : std::uint8_t { kUint8, kUint16, kFloat16, kFloat32 };

enum class ColorSpace : std::uint8_t {
  kSrgb,      // Rec.709 primaries, sRGB transfer function
  kLinear,    // Rec.709 primaries, linear radiance
  kNonColor,  // data: normals, roughness, masks
};

struct Extent {
  int width = 0;   // px
  int height = 0;  // px

  bool operator==(const Extent&) const = default;
  std::int64_t area() const { return std::int64_t{width} * height; }
};

std::size_t sample_bytes(SampleType type);

// Threads: a value. Owns: its pixels.
struct Image {
  Extent extent;
  int channels = 0;  // 1..4: Y, YA, RGB, RGBA
  SampleType type = SampleType::kUint8;
  ColorSpace color_space = ColorSpace::kLinear;
  std::vector<std::byte> pixels;

  std::size_t row_bytes() const { return std::size_t(extent.width) * channels * sample_bytes(type); }
  std::size_t byte_size() const { return pixels.size(); }

  // T must match `type` (std::uint8_t, std::uint16_t, float; kFloat16 as std::uint16_t bits).
  template <class T>
  std::span<T> samples() {
    return {reinterpret_cast<T*>(pixels.data()), pixels.size() / sizeof(T)};
  }
  template <class T>
  std::span<const T> samples() const {
    return {reinterpret_cast<const T*>(pixels.data()), pixels.size() / sizeof(T)};
  }
};

// Allocates zeroed pixels. Fails with kTooLarge when the bytes would exceed 2 GiB or an extent is not
// positive.
Image make_image(Extent extent, int channels, SampleType type, ColorSpace color_space);

// Round-to-nearest-even half conversion, exact; overflow gives infinity, a NaN stays one and becomes quiet.
std::uint16_t half_from_float(float value);
float float_from_half(std::uint16_t bits);
// The same for as many samples as both have (F16C when the CPU has it, same bits).
void half_from_float(std::span<const float> in, std::span<std::uint16_t> out);
void float_from_half(std::span<const std::uint16_t> in, std::span<float> out);

}  // namespace furnace
