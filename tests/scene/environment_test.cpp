#include "renderer/scene/procedural.hpp"

#include "renderer/base/content_hash.hpp"
#include "tests/scene/equirect_sums.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

namespace furnace {
namespace {

double peak(const Image& image) {
  double result = 0;
  for (const float sample : image.samples<float>()) result = std::max(result, double(sample));
  return result;
}

glm::dvec3 default_view_direction() {
  return glm::normalize(glm::dvec3(0.554, 0.259, 0.791));
}

TEST(BuiltinEnvironment, ContractNamesExistAndOthersDoNot) {
  EXPECT_THAT(builtin_environment_names(),
              testing::UnorderedElementsAre("studio", "overcast", "clear-sky", "furnace"));
  EXPECT_FALSE(builtin_environment("beach").has_value());
}

TEST(BuiltinEnvironment, IsALinearFloatEquirectOfHalfPrecision) {
  for (const std::string_view name : builtin_environment_names()) {
    SCOPED_TRACE(std::string(name));
    const Image image = *builtin_environment(name);
    EXPECT_EQ(image.extent.width, 2 * image.extent.height);
    EXPECT_EQ(image.channels, 3);
    EXPECT_EQ(image.type, SampleType::kFloat32);
    EXPECT_EQ(image.color_space, ColorSpace::kLinear);
    for (const float sample : image.samples<float>()) {
      ASSERT_TRUE(std::isfinite(sample) && sample >= 0);
      ASSERT_EQ(sample, float_from_half(half_from_float(sample)));
    }
  }
}

// Raise kRenderSpecVersion with these: the same request would give another picture.
TEST(BuiltinEnvironment, BytesAreTheSameOnEveryMachine) {
  const std::map<std::string_view, std::string_view> expected = {
      {"studio", "719381a3f1c57a3af90f12abe5b5e0867c94493cb78913c829292493aa4d98b4"},
      {"overcast", "59334a037024a96bcc160af1b79bbd3b58ae13f7843827c8f3cbe6e858800b40"},
      {"clear-sky", "5d4f4c4d303c9729d4907e73fd3c8ef9849375eee8be4f6381d38485f1ec4bf4"},
      {"furnace", "08f46753296b40512f918614f5b0be6f15e4a95fb0aeeff6c9026be0a396c4a7"}};
  for (const auto& [name, hash] : expected)
    EXPECT_EQ(hash_bytes(builtin_environment(name)->pixels).hex(), hash) << name;
}

TEST(ConstantEnvironment, IsTheColourEverywhere) {
  const glm::vec3 color(0.1f, 2.5f, 70000.f);
  const Image image = constant_environment(color);
  const auto samples = image.samples<float>();
  for (std::size_t i = 0; i < samples.size(); ++i) ASSERT_EQ(samples[i], color[i % 3]);
}

TEST(Furnace, IsOneEverywhere) {
  const Image furnace = *builtin_environment("furnace");
  for (const float sample : furnace.samples<float>()) ASSERT_EQ(sample, 1);
}

TEST(Studio, IsWellExposed) {
  const Image studio = *builtin_environment("studio");
  EXPECT_EQ(studio.extent, (Extent{1024, 512}));
  const glm::dvec3 up = irradiance_over_pi(studio, {0, 1, 0});
  const glm::dvec3 front = irradiance_over_pi(studio, default_view_direction());
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(up[i], 0.9);
    EXPECT_LT(up[i], 1.2);
    EXPECT_GT(front[i], 0.7);
    EXPECT_LT(front[i], 1);
    EXPECT_NEAR(up[i] / up.g, 1, 0.02);  // a grey card stays grey
  }
  EXPECT_GT(peak(studio), 15);
  EXPECT_LT(peak(studio), 25);
}

TEST(Studio, LightsTheDefaultPictureFromTheUpperLeftWithARim) {
  const Image studio = *builtin_environment("studio");
  const glm::dvec3 view = default_view_direction();
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), view)),
                   up = glm::cross(view, right);
  const auto light = [&](const glm::dvec3& normal) {
    return irradiance_over_pi(studio, glm::normalize(normal)).g;
  };
  EXPECT_GT(light(view - right + up), 1.5 * light(view + right - up));
  EXPECT_GT(light(right + 0.3 * up - view), light(view - up));
}

TEST(Overcast, FollowsItsClosedForms) {
  const Image sky = *builtin_environment("overcast");
  // Half precision, and 128 rows: under 1e-3.
  EXPECT_NEAR(irradiance_over_pi(sky, {0, 1, 0}).g, 1, 1e-3);
  const auto samples = sky.samples<float>();
  const int width = sky.extent.width;
  const double zenith = samples[0], horizon = samples[3 * (sky.extent.height / 2 - 1) * width];
  EXPECT_NEAR(zenith, 9.0 / 7, 1e-3 * zenith);
  EXPECT_NEAR(zenith / horizon, 3, 0.08);  // the last row's middle lies 0.7 degrees above the horizon
  const double nadir = samples[3 * (sky.extent.height - 1) * width];
  EXPECT_NEAR(nadir, 0.2, 0.025 * horizon);  // the haze between
}

TEST(ClearSky, ShowsAWhiteCardWhite) {
  const glm::dvec3 card = irradiance_over_pi(*builtin_environment("clear-sky"), {0, 1, 0});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(card[i], 1, 1e-3);  // half rounding of the sun's few texels
}

TEST(ClearSky, HasASunOfTrueSizeAtFortyFiveDegrees) {
  const Image sky = *builtin_environment("clear-sky");
  const auto samples = sky.samples<float>();
  const double threshold = 100;  // far above any sky, far below the disc
  double covered_sr = 0;
  glm::dvec3 sun(0);
  double energy = 0;
  for (int row = 0; row < sky.extent.height; ++row)
    for (int column = 0; column < sky.extent.width; ++column) {
      const double value = samples[3 * (row * sky.extent.width + column) + 1];
      if (value < threshold) continue;
      const double texel_sr = 2 * kPi / sky.extent.width * std::sin(kPi * (row + 0.5) / sky.extent.height) *
                              kPi / sky.extent.height;
      energy += value * texel_sr;
      covered_sr += texel_sr * value / peak(sky);
      sun += value * direction(sky, row, column);
    }
  sun = glm::normalize(sun);
  EXPECT_NEAR(std::asin(sun.y), kPi / 4, 0.002);  // a third of a texel
  EXPECT_GT(glm::dot(sun, default_view_direction()), 0);
  // The peak texel is wholly inside the disc, so its radiance is the sun's: the energy over it is the disc's
  // angle (the peak is that of blue or red; the channels differ by some 30 %).
  const double true_sr = 2 * kPi * (1 - std::cos(radians_from_degrees(0.2666)));
  EXPECT_NEAR(covered_sr / true_sr, 1, 0.35);
  EXPECT_GT(peak(sky), 1e4);
  EXPECT_LT(peak(sky), 65504);
  // On a clear day the sun gives most of the light.
  EXPECT_GT(energy * sun.y / kPi, 0.7);
  EXPECT_LT(energy * sun.y / kPi, 0.9);
}

TEST(ClearSky, IsBlueAboveBrighterNearTheSunAndDimBelow) {
  const Image sky = *builtin_environment("clear-sky");
  const auto samples = sky.samples<float>();
  const auto texel = [&](int row, int column) { return &samples[3 * (row * sky.extent.width + column)]; };
  const float* zenith = texel(0, 0);
  EXPECT_GT(zenith[2], 1.5 * zenith[0]);
  const int near_sun = 820, opposite = near_sun - 512, row = 100;
  EXPECT_GT(texel(row, near_sun)[1], 2 * texel(row, opposite)[1]);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(texel(511, 0)[i], 0.2, 0.02);
}

}  // namespace
}  // namespace furnace
