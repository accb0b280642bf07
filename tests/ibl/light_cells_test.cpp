#include "renderer/ibl/light_cells.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/ibl/light_sums.hpp"
#include "renderer/ibl/octahedral_atlas.hpp"

namespace furnace {
namespace {

using std::numbers::pi;

Image even_map(float r, float g, float b) {
  Image map = make_image({64, 32}, 4, SampleType::kFloat16, ColorSpace::kLinear);
  const auto samples = map.samples<std::uint16_t>();
  for (std::size_t i = 0; i < samples.size(); i += 4) {
    samples[i] = half_from_float(r);
    samples[i + 1] = half_from_float(g);
    samples[i + 2] = half_from_float(b);
  }
  return map;
}

std::array<double, 3> flux_of(const std::vector<LightDirection>& lights) {
  std::array<double, 3> sum{};
  for (const LightDirection& light : lights) {
    for (std::size_t c = 0; c < 3; ++c) sum[c] += light.irradiance[c];
  }
  return sum;
}

// Irradiance of a plane facing `normal`, over every `step`-th direction from `first` on, times `step`; red.
double irradiance(const std::vector<LightDirection>& lights, const std::array<double, 3>& normal,
                  std::size_t first = 0, std::size_t step = 1) {
  double sum = 0;
  for (std::size_t i = first; i < lights.size(); i += step) {
    const auto& d = lights[i].towards;
    sum += lights[i].irradiance[0] * std::max(0.0, d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]);
  }
  return sum * double(step);
}

TEST(LightCells, HoldTheMapsFlux) {
  for (const int count : {1, 16, 100}) {
    const auto lights = light_cells(even_map(1, 0.5f, 0.25f), count);
    ASSERT_EQ(lights.size(), std::size_t(count));
    const auto flux = flux_of(lights);
    EXPECT_NEAR(flux[0], 4 * pi, 1e-9);
    EXPECT_NEAR(flux[1], 2 * pi, 1e-9);
    EXPECT_NEAR(flux[2], pi, 1e-9);
  }
}

// To the last digits, so that an even map is even in what is made of the cells.
TEST(LightCells, HoldTheSphere) {
  double sphere_sr = 0;
  for (const LightDirection& light : light_cells(even_map(1, 0.5f, 0.25f), 100)) {
    sphere_sr += light.solid_angle_sr;
    EXPECT_NEAR(light.irradiance[2] / light.solid_angle_sr, 0.25, 1e-12);
  }
  EXPECT_NEAR(sphere_sr, 4 * pi, 1e-9);
}

// Of an even sky every plane has pi. Random directions would err by 1 / sqrt(3 * 256) = 3.6 % (one standard deviation).
TEST(LightCells, SpreadOverTheSphereAndSoDoesEachSubset) {
  const auto lights = light_cells(even_map(1, 1, 1), 256);
  for (const LightDirection& light : lights) {
    const auto& d = light.towards;
    EXPECT_NEAR(d[0] * d[0] + d[1] * d[1] + d[2] * d[2], 1, 1e-12);
  }
  const double s = std::sqrt(1.0 / 3);
  for (const std::array<double, 3>& normal :
       {std::array{0.0, 1.0, 0.0}, {0.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {s, s, s}, {-s, s, -s}}) {
    EXPECT_NEAR(irradiance(lights, normal) / pi, 1, 0.02);
    // 16 random directions: 14 %, three times as much at most.
    for (const std::size_t first : {0u, 5u, 15u})
      EXPECT_NEAR(irradiance(lights, normal, first, 16) / pi, 1, 0.45) << first;
  }
}

TEST(LightCells, CrowdWhereTheLightIs) {
  Image map = even_map(0.1f, 0.1f, 0.1f);
  const auto samples = map.samples<std::uint16_t>();
  for (std::size_t j = 8; j < 12; ++j) {  // 45 to 67.5 degrees from +Y, round +X
    for (std::size_t i = 30; i < 34; ++i) {
      for (std::size_t c = 0; c < 3; ++c) samples[(j * 64 + i) * 4 + c] = half_from_float(40);
    }
  }
  const auto lights = light_cells(map, 128);
  std::size_t in_lamp = 0;
  double lamp = 0;
  for (const LightDirection& light : lights) {
    const double theta = std::acos(light.towards[1]), phi = std::atan2(light.towards[2], light.towards[0]);
    if (theta < pi / 4 - 0.02 || theta > pi * 3 / 8 + 0.02 || std::abs(phi) > pi / 16 + 0.02) continue;
    ++in_lamp;
    lamp += light.irradiance[0];
  }
  // The lamp has 40 of its solid angle; as much as all light is dealt evenly.
  const double lamp_flux = 40 * (std::cos(pi / 4) - std::cos(pi * 3 / 8)) * pi / 8;
  const double flux = flux_of(lights)[0];
  EXPECT_NEAR(double(in_lamp) / 128, lamp_flux / flux / 2, 0.05);
  EXPECT_NEAR(lamp, lamp_flux, 0.08 * lamp_flux);
}

// In the corner texels, which the maps reach exactly.
TEST(LightSums, AreTheSumsOverAllDirections) {
  const auto lights = light_cells(even_map(1, 0.5f, 0.25f), 64);
  constexpr int kSide = 9, kLevels = 3;
  WorkerPool pool(2);
  const LightSums sums = light_sums(lights, kSide, kLevels, pool);
  EXPECT_NEAR(sums.least_alpha, 3.0 / 8, 1e-12);
  const auto samples = sums.maps.samples<float>();
  for (const auto& [x, y] : {std::pair{0, 0}, {4, 4}, {8, 3}}) {
    const auto at = direction_from_octahedral(x / 8.0, y / 8.0);
    const auto row = [&](int level) { return &samples[std::size_t(((level * kSide + y) * kSide + x) * 4)]; };
    EXPECT_NEAR(row(0)[0], irradiance(lights, at), 1e-5);
    for (int level = 0; level < kLevels; ++level) {
      double blue = 0, even = 0;
      for (const LightDirection& light : lights) {
        const auto& d = light.towards;
        const double alpha = std::pow(sums.least_alpha, 1 - level / 2.0);
        const double lobe =
            ggx_lobe(d[0] * at[0] + d[1] * at[1] + d[2] * at[2], alpha) / ggx_lobe_integral_sr(alpha);
        blue += light.irradiance[2] * lobe;
        even += light.solid_angle_sr * lobe;
      }
      EXPECT_NEAR(row(1 + level)[2], blue, 1e-5) << level;
      EXPECT_NEAR(row(1 + level)[3], even, 1e-5) << level;
    }
  }
}

TEST(LightSums, ALobeIsOneInItsMiddleAndNothingBehind) {
  for (const double alpha : {0.1, 0.5, 1.0}) {
    EXPECT_DOUBLE_EQ(ggx_lobe(1, alpha), 1);
    EXPECT_EQ(ggx_lobe(-0.5, alpha), 0);
    EXPECT_LT(ggx_lobe(0.8, alpha), 0.81);
  }
}

TEST(LightSums, ALobesIntegralIsItsSumOverTheSphere) {
  for (const double alpha : {0.05, 0.3, 0.95, 0.9999, 1.0}) {
    double sum = 0;
    constexpr int kSteps = 100'000;
    for (int i = 0; i < kSteps; ++i) {
      const double x = (i + 0.5) / kSteps;  // crowded at the middle: cosine 1 - x^3
      sum += ggx_lobe(1 - x * x * x, alpha) * 3 * x * x / kSteps;
    }
    EXPECT_NEAR(ggx_lobe_integral_sr(alpha) / (2 * pi * sum), 1, 1e-6) << alpha;
  }
}

TEST(LightCells, OfABlackMapAreNone) {
  EXPECT_TRUE(light_cells(even_map(0, 0, 0), 16).empty());
}

}  // namespace
}  // namespace furnace
