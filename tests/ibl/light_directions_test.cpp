#include "renderer/ibl/light_directions.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace furnace {
namespace {

using std::numbers::pi;

Image dark_map() {
  return make_image({64, 32}, 4, SampleType::kFloat16, ColorSpace::kLinear);
}

void paint(Image& map, int i, int j, float r, float g, float b) {
  const auto samples = map.samples<std::uint16_t>();
  const std::size_t at = (std::size_t(j) * 64 + std::size_t(i)) * 4;
  samples[at] = half_from_float(r);
  samples[at + 1] = half_from_float(g);
  samples[at + 2] = half_from_float(b);
}

// Sum of weight times f(direction), green.
template <class F>
double sum(const std::vector<LightDirection>& lights, const F& f) {
  double result = 0;
  for (const LightDirection& light : lights) result += light.irradiance[1] * f(light.towards);
  return result;
}

TEST(GroundLight, OfAConstantSkyIsAsDenseAsItsCosine) {
  Image map = dark_map();
  for (int j = 0; j < 32; ++j) {
    for (int i = 0; i < 64; ++i) paint(map, i, j, 1, 1, 1);
  }
  const auto lights = ground_light(map, 512);
  ASSERT_EQ(lights.size(), 512u);
  for (const LightDirection& light : lights) {
    const auto& d = light.towards;
    EXPECT_NEAR(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 1e-12);
    EXPECT_GT(d[1], 0);
  }
  // Over the cosine-weighted hemisphere.
  EXPECT_NEAR(sum(lights, [](const auto&) { return 1.0; }), pi, 1e-9);
  EXPECT_NEAR(sum(lights, [](const auto& d) { return d[1]; }), pi * 2 / 3, 1e-2);
  EXPECT_NEAR(sum(lights, [](const auto& d) { return d[0]; }), 0, 1e-2);
  EXPECT_NEAR(sum(lights, [](const auto& d) { return d[2] * d[2]; }), pi / 4, 1e-2);
}

TEST(GroundLight, ColoursKeepTheirOwnShares) {
  Image map = dark_map();
  paint(map, 10, 4, 4, 1, 0);   // two texels of different colours and elevations,
  paint(map, 40, 12, 0, 1, 2);  // and nothing blue in the first
  const auto lights = ground_light(map, 400);
  const auto weight = [](int j) {
    return std::pow(std::sin(pi * (j + 1) / 32), 2) - std::pow(std::sin(pi * j / 32), 2);
  };
  std::array<double, 3> high{}, low{};
  for (const LightDirection& light : lights) {
    auto& of = light.towards[1] > 0.7 ? high : low;
    for (std::size_t c = 0; c < 3; ++c) of[c] += light.irradiance[c];
  }
  const double texel = pi / 64;  // its irradiance for a radiance of 1 is this times weight(j)
  EXPECT_EQ(high[2], 0);
  EXPECT_EQ(low[0], 0);
  EXPECT_NEAR(high[0] / (4 * texel * weight(4)), 1, 2e-2);
  EXPECT_NEAR(high[1] / (texel * weight(4)), 1, 2e-2);
  EXPECT_NEAR(low[2] / (2 * texel * weight(12)), 1, 2e-2);
}

TEST(GroundLight, ALongerListRefinesAShorterOne) {
  Image map = dark_map();
  paint(map, 3, 3, 1, 1, 1);
  paint(map, 50, 9, 2, 2, 2);
  const auto few = ground_light(map, 20), many = ground_light(map, 200);
  for (std::size_t i = 0; i < few.size(); ++i) EXPECT_EQ(few[i].towards, many[i].towards);
}

TEST(GroundLight, OfADiscLiesInIt) {
  const std::array<double, 3> towards{0.6, 0.64, -0.48};
  const auto lights = ground_light(towards, {3, 2, 1}, 0.02, 64);
  ASSERT_EQ(lights.size(), 64u);
  std::array<double, 3> mean{};
  for (const LightDirection& light : lights) {
    double cosine = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      cosine += light.towards[i] * towards[i];
      mean[i] += light.towards[i] / 64;
    }
    EXPECT_LE(std::acos(cosine), 0.02 + 1e-9);
  }
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(mean[i], towards[i], 1e-3);
  EXPECT_NEAR(sum(lights, [](const auto&) { return 1.0; }), 2 * 0.64, 1e-9);
  EXPECT_TRUE(ground_light({0, -1, 0}, {1, 1, 1}, 0.01, 8).empty());
}

TEST(GroundLight, JoinedSourcesKeepTheirLight) {
  const auto one = ground_light({0, 1, 0}, {9, 9, 9}, 0.01, 100);
  const auto other = ground_light({0.6, 0.8, 0}, {1 / 0.8, 1 / 0.8, 1 / 0.8}, 0.01, 100);
  const auto joined = joined_by_light({one, other}, 100);
  EXPECT_EQ(joined.size(), 100u);
  const auto is_first = [](const auto& d) { return d[1] > 0.9 ? 1.0 : 0.0; };
  EXPECT_NEAR(sum(joined, is_first), 9, 1e-9);
  EXPECT_NEAR(sum(joined, [](const auto&) { return 1.0; }), 10, 1e-9);
}

TEST(GroundLight, NoneFromBelowOrFromTheDark) {
  Image map = dark_map();
  EXPECT_TRUE(ground_light(map, 16).empty());
  paint(map, 5, 16, 9, 9, 9);
  EXPECT_TRUE(ground_light(map, 16).empty());
}

}  // namespace
}  // namespace furnace
