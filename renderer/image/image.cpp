#include "renderer/image/image.hpp"

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

#include <bit>
#include <string>

namespace furnace {

namespace {

constexpr std::int64_t kMaxImageBytes = std::int64_t{2} << 30;

#if defined(__x86_64__)

// Both return how many samples they did: a multiple of 8.
__attribute__((target("avx,f16c"))) std::size_t convert_by_f16c(std::span<const float> in,
                                                                std::uint16_t* out) {
  std::size_t i = 0;
  for (; i + 8 <= in.size(); i += 8) {
    const __m256 floats = _mm256_loadu_ps(in.data() + i);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + i), _mm256_cvtps_ph(floats, _MM_FROUND_TO_NEAREST_INT));
  }
  return i;
}

__attribute__((target("avx,f16c"))) std::size_t convert_by_f16c(std::span<const std::uint16_t> in,
                                                                float* out) {
  std::size_t i = 0;
  for (; i + 8 <= in.size(); i += 8) {
    const __m128i halves = _mm_loadu_si128(reinterpret_cast<const __m128i*>(in.data() + i));
    _mm256_storeu_ps(out + i, _mm256_cvtph_ps(halves));
  }
  return i;
}

// Not every compiler's __builtin_cpu_supports knows of F16C; that of AVX also says whether the system keeps its registers.
bool cpu_has_f16c() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __builtin_cpu_supports("avx") && __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C) != 0;
}

const bool has_f16c = cpu_has_f16c();

template <class In, class Out>
std::size_t convert_by_hardware(std::span<const In> in, Out* out) {
  return has_f16c ? convert_by_f16c(in, out) : 0;
}

#else

template <class In, class Out>
std::size_t convert_by_hardware(std::span<const In>, Out*) {
  return 0;
}

#endif

}  // namespace

std::size_t sample_bytes(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return 1;
    case SampleType::kUint16:
      return 2;
    case SampleType::kFloat16:
      return 2;
    case SampleType::kFloat32:
      return 4;
  }
  return 0;
}

Image make_image(Extent extent, int channels, SampleType type, ColorSpace color_space) {
  FURNACE_CHECK(channels >= 1 && channels <= 4, "{} channels", channels);
  // Neither product below can overflow: area() has 62 bits at most and is compared by division.
  const std::int64_t pixel_bytes = channels * static_cast<std::int64_t>(sample_bytes(type));
  const bool positive = extent.width > 0 && extent.height > 0;
  if (!positive || extent.area() > kMaxImageBytes / pixel_bytes) {
    fail(ErrorCode::kTooLarge,
         "an image of " + std::to_string(extent.width) + " x " + std::to_string(extent.height) +
             " pixels and " + std::to_string(pixel_bytes) + " bytes per pixel is empty or larger than 2 GiB");
  }
  Image image{extent, channels, type, color_space, {}};
  image.pixels.resize(static_cast<std::size_t>(extent.area() * pixel_bytes));
  return image;
}

std::uint16_t half_from_float(float value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = (bits >> 16) & 0x8000u;
  const std::uint32_t magnitude = bits & 0x7fffffffu;
  const auto with_sign = [&](std::uint32_t half) { return static_cast<std::uint16_t>(sign | half); };

  if (magnitude > 0x7f800000u) return with_sign(0x7e00u | ((magnitude >> 13) & 0x3ffu));  // NaN, made quiet
  if (magnitude >= 0x47800000u) return with_sign(0x7c00u);                                // 65536 and above
  if (magnitude >= 0x38800000u) {  // normal: rebias the exponent from 127 to 15; a carry may end in infinity
    const std::uint32_t rebiased = magnitude - (112u << 23);
    return with_sign((rebiased + 0xfffu + ((rebiased >> 13) & 1u)) >> 13);
  }
  if (magnitude < 0x33000000u) return with_sign(0);  // below half of the smallest subnormal
  // Subnormal: the significand in units of 2^-24; `shift` bits of it fall off.
  const std::uint32_t significand = (magnitude & 0x7fffffu) | 0x800000u;
  const int shift = 126 - static_cast<int>(magnitude >> 23);
  const std::uint32_t rounding = (1u << (shift - 1)) - 1u + ((significand >> shift) & 1u);
  return with_sign((significand + rounding) >> shift);
}

float float_from_half(std::uint16_t bits) {
  const std::uint32_t sign = (bits & 0x8000u) << 16;
  const std::uint32_t exponent = (bits >> 10) & 31u;
  const std::uint32_t mantissa = bits & 0x3ffu;
  if (exponent == 31) {
    const std::uint32_t quiet = mantissa ? 0x400000u : 0u;
    return std::bit_cast<float>(sign | 0x7f800000u | quiet | (mantissa << 13));
  }
  if (exponent > 0) return std::bit_cast<float>(sign | ((exponent + 112u) << 23) | (mantissa << 13));
  const float magnitude = static_cast<float>(mantissa) * 0x1p-24f;  // exact
  return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(magnitude));
}

void half_from_float(std::span<const float> in, std::span<std::uint16_t> out) {
  FURNACE_CHECK(in.size() == out.size(), "{} samples into {}", in.size(), out.size());
  for (std::size_t i = convert_by_hardware(in, out.data()); i < in.size(); ++i)
    out[i] = half_from_float(in[i]);
}

void float_from_half(std::span<const std::uint16_t> in, std::span<float> out) {
  FURNACE_CHECK(in.size() == out.size(), "{} samples into {}", in.size(), out.size());
  for (std::size_t i = convert_by_hardware(in, out.data()); i < in.size(); ++i)
    out[i] = float_from_half(in[i]);
}

}  // namespace furnace
