// Smaller pictures against the mean of the light over each pixel's area.
#include "tests/image/sample_files.hpp"
#include "renderer/image/color.hpp"
#include "renderer/image/downscale.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace furnace {
namespace {

Image image_of(Extent extent, int channels, ColorSpace space, const std::vector<std::uint8_t>& samples) {
  Image image = make_image(extent, channels, SampleType::kUint8, space);
  std::ranges::copy(samples, image.samples<std::uint8_t>().begin());
  return image;
}

std::vector<int> samples_of(const Image& image) {
  const auto samples = image.samples<std::uint8_t>();
  return {samples.begin(), samples.end()};
}

// Half black and half white is half the light: 188 of sRGB, 128 of data; alpha is data always.
TEST(Downscale, AveragesLight) {
  const std::vector<std::uint8_t> checks{0, 255, 255, 0};
  EXPECT_EQ(samples_of(downscaled(image_of({2, 2}, 1, ColorSpace::kSrgb, checks), {1, 1})),
            std::vector<int>{188});
  EXPECT_EQ(samples_of(downscaled(image_of({2, 2}, 1, ColorSpace::kNonColor, checks), {1, 1})),
            std::vector<int>{128});
  EXPECT_EQ(samples_of(downscaled(image_of({2, 1}, 2, ColorSpace::kSrgb, {0, 0, 255, 255}), {1, 1})),
            (std::vector<int>{188, 128}));
}

TEST(Downscale, CoversPartsOfPixels) {
  // 3 -> 2: the first takes the whole of pixel 0 and half of pixel 1.
  EXPECT_EQ(samples_of(downscaled(image_of({3, 1}, 1, ColorSpace::kNonColor, {30, 90, 240}), {2, 1})),
            (std::vector<int>{50, 190}));
  EXPECT_EQ(samples_of(downscaled(image_of({1, 3}, 1, ColorSpace::kNonColor, {30, 90, 240}), {1, 2})),
            (std::vector<int>{50, 190}));
}

TEST(Downscale, KeepsTheWholeLight) {
  const Extent from{97, 61}, to{40, 13};
  Image image = make_image(from, 3, SampleType::kUint16, ColorSpace::kNonColor);
  const auto noise = sample::noise(image.pixels.size(), 5);
  std::memcpy(image.pixels.data(), noise.data(), noise.size());
  const Image small = downscaled(image, to);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto mean = [&](const Image& picture) {
      double sum = 0;
      for (std::size_t i = c; i < picture.samples<std::uint16_t>().size(); i += 3)
        sum += picture.samples<std::uint16_t>()[i];
      return sum / double(picture.extent.area());
    };
    EXPECT_NEAR(mean(small), mean(image), 1);
  }
}

TEST(Downscale, FlatStaysFlatAndTheSameSizeStaysTheSame) {
  const Image flat = image_of({7, 5}, 3, ColorSpace::kSrgb, std::vector<std::uint8_t>(105, 201));
  for (const int sample : samples_of(downscaled(flat, {3, 2}))) EXPECT_EQ(sample, 201);
  const Image noise = image_of({7, 5}, 4, ColorSpace::kSrgb, sample::noise(140, 2));
  EXPECT_EQ(downscaled(noise, {7, 5}).pixels, noise.pixels);
}

TEST(Downscale, FitsWithinASide) {
  EXPECT_EQ(fitted({100, 50}, 100), (Extent{100, 50}));
  EXPECT_EQ(fitted({100, 50}, 10), (Extent{10, 5}));
  EXPECT_EQ(fitted({1, 1000}, 10), (Extent{1, 10}));
}

TEST(Downscale, TexturesWithALongerSideAreScaledAndToldOf) {
  const Blob file(sample::png(40, 10, std::vector<std::uint8_t>(1200, 90), {}));
  const DecodedTexture texture = decode_texture(file, ColorSpace::kSrgb, {.max_side_px = 20});
  ASSERT_EQ(texture.levels.size(), 1u);
  EXPECT_EQ(texture.levels[0].extent, (Extent{20, 5}));
  ASSERT_EQ(texture.remarks.size(), 1u);
  EXPECT_EQ(texture.remarks[0].code, "texture-downscaled");
  EXPECT_TRUE(decode_texture(file, ColorSpace::kSrgb, {.max_side_px = 40}).remarks.empty());
  EXPECT_EQ(sample::error_of([&] {
              decode_texture(file, ColorSpace::kSrgb, {20, 399});
            }).code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace furnace
