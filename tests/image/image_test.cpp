#include "renderer/image/image.hpp"

#include "tests/image/sample_files.hpp"
#include "renderer/image/color.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace furnace {
namespace {

constexpr std::uint16_t kHalfInfinity = 0x7c00;

// IEEE 754-2008, binary16: what a half means, in exact arithmetic.
double meaning_of_half(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 31, mantissa = bits & 1023;
  const double magnitude = exponent == 31  ? (mantissa ? std::numeric_limits<double>::quiet_NaN()
                                                       : std::numeric_limits<double>::infinity())
                           : exponent == 0 ? std::ldexp(mantissa, -24)
                                           : std::ldexp(1024 + mantissa, exponent - 25);
  return bits & 0x8000 ? -magnitude : magnitude;
}

TEST(Half, MeansWhatIeee754Says) {
  for (std::uint32_t bits = 0; bits < 65536; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    const float value = float_from_half(half);
    const double expected = meaning_of_half(half);
    ASSERT_EQ(std::signbit(value), std::signbit(expected)) << bits;
    if (std::isnan(expected)) {
      ASSERT_TRUE(std::isnan(value)) << bits;
      ASSERT_TRUE(std::isnan(float_from_half(half_from_float(value)))) << bits;
    } else {
      ASSERT_EQ(value, expected) << bits;
      ASSERT_EQ(half_from_float(value), half) << bits;
    }
  }
}

// Between any two neighbours: the tie goes to the even one, its neighbours to the nearer one.
TEST(Half, RoundsToNearestEven) {
  for (std::uint16_t half = 0; half < kHalfInfinity; ++half) {
    const auto next = static_cast<std::uint16_t>(half + 1);
    // Above the largest finite half the next step is 65536, which is written as infinity.
    const double upper = next == kHalfInfinity ? 65536.0 : meaning_of_half(next);
    const auto middle = static_cast<float>((meaning_of_half(half) + upper) / 2);  // exact: one bit more
    const std::uint16_t even = half % 2 == 0 ? half : next;
    ASSERT_EQ(half_from_float(middle), even) << half;
    ASSERT_EQ(half_from_float(-middle), even | 0x8000) << half;
    ASSERT_EQ(half_from_float(std::nextafter(middle, 0.0f)), half) << half;
    ASSERT_EQ(half_from_float(std::nextafter(middle, 1e9f)), next) << half;
  }
}

TEST(Half, HandlesTheExtremes) {
  EXPECT_EQ(half_from_float(65504.0f), 0x7bff);
  EXPECT_EQ(half_from_float(65519.996f), 0x7bff);
  EXPECT_EQ(half_from_float(65520.0f), kHalfInfinity);
  EXPECT_EQ(half_from_float(std::numeric_limits<float>::max()), kHalfInfinity);
  EXPECT_EQ(half_from_float(-std::numeric_limits<float>::infinity()), 0xfc00);
  EXPECT_EQ(half_from_float(std::numeric_limits<float>::denorm_min()), 0);
  EXPECT_EQ(half_from_float(-0.0f), 0x8000);
  EXPECT_EQ(half_from_float(0x1p-25f), 0);  // a tie, to even
  EXPECT_EQ(half_from_float(0x1.000002p-25f), 1);
}

TEST(Half, ConvertsManyAsItConvertsOne) {
  std::vector<std::uint16_t> halves(65536 + 3);  // not a multiple of any vector
  for (std::size_t i = 0; i < halves.size(); ++i) halves[i] = static_cast<std::uint16_t>(i);
  std::vector<float> floats(halves.size());
  float_from_half(halves, floats);
  for (std::size_t i = 0; i < halves.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint32_t>(floats[i]),
              std::bit_cast<std::uint32_t>(float_from_half(halves[i])))
        << i;
  }
  std::mt19937 random(1);
  for (float& value : floats) value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  half_from_float(floats, halves);
  for (std::size_t i = 0; i < halves.size(); ++i) {
    ASSERT_EQ(halves[i], half_from_float(floats[i])) << std::bit_cast<std::uint32_t>(floats[i]);
  }
}

TEST(Image, IsMadeOfZeros) {
  const Image image = make_image({5, 3}, 4, SampleType::kUint16, ColorSpace::kNonColor);
  EXPECT_EQ(image.row_bytes(), 40u);
  EXPECT_EQ(image.byte_size(), 120u);
  EXPECT_EQ(image.samples<std::uint16_t>().size(), 60u);
  for (std::uint16_t sample : image.samples<std::uint16_t>()) EXPECT_EQ(sample, 0);
  EXPECT_EQ(make_image({2, 2}, 1, SampleType::kUint8, ColorSpace::kSrgb).byte_size(), 4u);
  EXPECT_EQ(make_image({2, 2}, 3, SampleType::kFloat16, ColorSpace::kSrgb).byte_size(), 24u);
  EXPECT_EQ(make_image({2, 2}, 3, SampleType::kFloat32, ColorSpace::kSrgb).byte_size(), 48u);
}

TEST(Image, RefusesExtentsBeforeItAllocates) {
  constexpr int kMax = std::numeric_limits<int>::max(), kMin = std::numeric_limits<int>::min();
  for (const Extent extent :
       {Extent{0, 1}, Extent{1, 0}, Extent{-1, -1}, Extent{kMin, kMin}, Extent{kMax, kMax},
        Extent{kMin, kMax}, Extent{65536, 65536}, Extent{kMax, 1}, Extent{16384, 8193}}) {
    const Error error =
        sample::error_of([&] { make_image(extent, 4, SampleType::kFloat32, ColorSpace::kLinear); });
    EXPECT_EQ(error.code, ErrorCode::kTooLarge) << extent.width << " x " << extent.height;
  }
}

TEST(ImageDeathTest, RefusesImpossibleChannels) {
  EXPECT_DEATH(make_image({1, 1}, 5, SampleType::kUint8, ColorSpace::kSrgb), "5 channels");
  EXPECT_DEATH(make_image({1, 1}, 0, SampleType::kUint8, ColorSpace::kSrgb), "0 channels");
}

// IEC 61966-2-1 gives these points; 1e-6 because its own constants have five digits.
TEST(Color, TransferFunctionsAreInverses) {
  EXPECT_EQ(linear_from_srgb(0), 0);
  EXPECT_NEAR(linear_from_srgb(1), 1, 1e-12);
  EXPECT_NEAR(linear_from_srgb(0.5), 0.2140411, 1e-6);
  EXPECT_NEAR(srgb_from_linear(0.18), 0.4613561, 1e-6);
  for (int i = 0; i <= 4095; ++i) {
    const double x = i / 4095.0;
    // The two branches of the standard meet only to 5 digits, so next to the joint the round trip is that good.
    EXPECT_NEAR(srgb_from_linear(linear_from_srgb(x)), x, std::abs(x - 0.04045) < 1e-3 ? 1e-6 : 1e-12);
  }
}

TEST(Color, LuminanceOfWhiteIsOne) {
  EXPECT_NEAR(luminance_rec709(1, 1, 1), 1, 1e-12);
}

}  // namespace
}  // namespace furnace
