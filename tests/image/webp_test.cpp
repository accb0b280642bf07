#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"

#include <gtest/gtest.h>

namespace furnace {
namespace {

TEST(WebpDecode, ReadsLosslessPixelsExactly) {
  for (int channels : {3, 4}) {
    auto samples = sample::noise(31u * 17u * static_cast<std::size_t>(channels), 3);
    // WebP drops the colour of invisible pixels.
    for (std::size_t i = 3; channels == 4 && i < samples.size(); i += 4) samples[i] |= 1;
    const Image image = decode_texture(Blob(sample::lossless_webp(31, 17, channels, samples)),
                                       ColorSpace::kSrgb, DecodeLimits{});
    ASSERT_EQ(image.extent, (Extent{31, 17}));
    ASSERT_EQ(image.channels, channels);
    EXPECT_TRUE(std::ranges::equal(image.samples<std::uint8_t>(), samples));
  }
}

TEST(WebpDecode, ChecksLimitsFirst) {
  const Blob file(sample::lossless_webp(20, 10, 3, std::vector<std::uint8_t>(600)));
  EXPECT_EQ(sample::error_of([&] { decode_texture(file, ColorSpace::kSrgb, {.max_side_px = 19}); }).code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace furnace
