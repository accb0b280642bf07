// What is spread keeps its sum and has the widths that are asked for.
#include "renderer/frame/bloom.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace furnace {
namespace {

Image black(Extent size) {
  return make_image(size, 4, SampleType::kFloat32, ColorSpace::kLinear);
}

double sum_of(const Image& image, std::size_t channel) {
  const auto samples = image.samples<float>();
  double sum = 0;
  for (std::size_t i = channel; i < samples.size(); i += 4) sum += double(samples[i]);
  return sum;
}

float& at(Image& image, int x, int y, int channel) {
  return image.samples<float>()[std::size_t((y * image.extent.width + x) * 4 + channel)];
}

TEST(Bloom, TheSmallPictureHasOneHeight) {
  RenderSpec spec;
  spec.output.bloom.emplace();
  spec.output.samples = 64;
  const auto planned = [&](int width, int height) {
    spec.output.width = width;
    spec.output.height = height;
    const FramePlan plan = plan_glow(plan_frame(spec, 2048), 2048);
    EXPECT_TRUE(plan.glow_only);
    EXPECT_EQ(plan.film_type, SampleType::kFloat32);
    EXPECT_EQ(plan.jitter_px.size(), 16u);
    return plan.picture;
  };
  EXPECT_EQ(planned(256, 256), (Extent{256, 256}));
  EXPECT_EQ(planned(4096, 4096), (Extent{256, 256}));
  EXPECT_EQ(planned(1920, 1080), (Extent{480, 256}));  // 455, up to a multiple of 32
  EXPECT_EQ(planned(16, 1024), (Extent{32, 256}));
  EXPECT_EQ(planned(16384, 16), (Extent{1024, 256}));
}

TEST(Bloom, ASumStaysEvenAtTheBorder) {
  for (const double radius : {0.01, 0.1, 0.4, 1.0}) {
    Image bright = black({96, 256});
    at(bright, 0, 0, 0) = 1000;
    at(bright, 95, 130, 1) = 10;
    at(bright, 40, 255, 2) = 1;
    Bloom bloom;
    bloom.radius = radius;
    const Image glow = spread_glow(bright, bloom, {96, 256});
    EXPECT_NEAR(sum_of(glow, 0), 1000, 1e-2) << radius;
    EXPECT_NEAR(sum_of(glow, 1), 10, 1e-4) << radius;
    EXPECT_NEAR(sum_of(glow, 2), 1, 1e-5) << radius;
  }
}

TEST(Bloom, AnEvenPictureStaysEven) {
  Image bright = black({64, 256});
  for (float& value : bright.samples<float>()) value = 3;
  for (const double radius : {0.01, 0.1, 1.0}) {
    Bloom bloom;
    bloom.radius = radius;
    const Image glow = spread_glow(bright, bloom, {64, 256});
    for (const float value : glow.samples<float>()) ASSERT_NEAR(value, 3, 1e-5);
  }
}

// Five Gaussians of equal energy: the mean of their variances, with s the widest's: s^2 (1 + 1/4 + 1/16 + 1/64 + 1/256) / 5.
// A picture twice as wide as its small one has pixels twice as wide there.
TEST(Bloom, HasTheWidthAskedFor) {
  for (const int pixel_width : {1, 2}) {
    Image bright = black({256, 256});
    at(bright, 128, 128, 0) = 1;
    Bloom bloom;
    bloom.radius = 0.2;
    const Image glow = spread_glow(bright, bloom, {256 * pixel_width, 256});
    const auto samples = glow.samples<float>();
    glm::dvec2 variance(0);
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 256; ++x) {
        const auto value = double(samples[std::size_t((y * 256 + x) * 4)]);
        variance += value * glm::dvec2((x - 128) * (x - 128), (y - 128) * (y - 128));
      }
    }
    const double widest = 0.1 * 256;
    const double expected = widest * widest * (341.0 / 256) / 5;
    // Cut at three standard deviations a Gaussian has lost 3 % of its variance, and halving and doubling add less than 1 %.
    EXPECT_NEAR(variance.y, expected, 0.04 * expected);
    EXPECT_NEAR(variance.x * pixel_width * pixel_width, expected, 0.04 * expected);
  }
}

// No step between neighbours is larger than a Gaussian's steepest slope allows; a picture of blocks would have such.
TEST(Bloom, IsSmooth) {
  Image bright = black({256, 256});
  at(bright, 100, 90, 0) = 1e6f;
  Bloom bloom;
  bloom.radius = 1;
  const Image glow = spread_glow(bright, bloom, {256, 256});
  const auto samples = glow.samples<float>();
  const double narrowest = 0.5 * 256 / 16;
  const double steepest = 1e6 / 5 / (2 * std::acos(-1)) * std::exp(-0.5) / std::pow(narrowest, 3) * 1.4;
  for (std::size_t i = 4; i < samples.size(); i += 4) {
    if (i / 4 % 256 == 0) continue;
    ASSERT_LE(std::abs(double(samples[i]) - double(samples[i - 4])), steepest) << i;
  }
}

}  // namespace
}  // namespace furnace
