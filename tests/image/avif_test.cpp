#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace furnace {
namespace {

TEST(AvifDecode, ReadsLosslessPixelsExactly) {
  for (const int channels : {3, 4}) {
    const auto samples = sample::noise(31u * 17u * unsigned(channels), 3);
    const std::string file = sample::lossless_avif(31, 17, channels, 8, samples);
    ASSERT_EQ(sniff_image_format(std::as_bytes(std::span(file))), ImageFormat::kAvif);
    const Image image = sample::picture(file, ColorSpace::kSrgb);
    ASSERT_EQ(image.extent, (Extent{31, 17}));
    ASSERT_EQ(image.channels, channels);
    EXPECT_TRUE(std::ranges::equal(image.samples<std::uint8_t>(), samples));
  }
}

TEST(AvifDecode, KeepsMoreThanEightBits) {
  std::vector<std::uint16_t> deep(16 * 16 * 3);
  for (std::size_t i = 0; i < deep.size(); ++i) deep[i] = std::uint16_t(i * 37 % 1024);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(deep.data());
  const Image image = sample::picture(sample::lossless_avif(16, 16, 3, 10, {bytes, bytes + deep.size() * 2}),
                                      ColorSpace::kNonColor);
  ASSERT_EQ(image.type, SampleType::kUint16);
  for (std::size_t i = 0; i < deep.size(); ++i)
    ASSERT_NEAR(image.samples<std::uint16_t>()[i], deep[i] * 65535.0 / 1023, 1) << i;
}

TEST(AvifDecode, ChecksLimitsFirst) {
  const Blob file(sample::lossless_avif(20, 10, 3, 8, std::vector<std::uint8_t>(600)));
  EXPECT_EQ(sample::error_of([&] { decode_texture(file, ColorSpace::kSrgb, {.max_area_px = 199}); }).code,
            ErrorCode::kTooLarge);
}

TEST(AvifDecode, IsKnownByItsBrands) {
  const auto format = [](const std::string& text) {
    return sniff_image_format(std::as_bytes(std::span(text)));
  };
  const std::string head(
      "\0\0\0\x18"
      "ftyp",
      8);
  EXPECT_EQ(format(head + std::string("avif\0\0\0\0mif1miaf", 16)), ImageFormat::kAvif);
  EXPECT_EQ(format(head + std::string("mif1\0\0\0\0miafavif", 16)), ImageFormat::kAvif);
  EXPECT_EQ(format(head + std::string("heic\0\0\0\0mif1heic", 16)), ImageFormat::kUnknown);
  EXPECT_EQ(format(head), ImageFormat::kUnknown);
}

}  // namespace
}  // namespace furnace
