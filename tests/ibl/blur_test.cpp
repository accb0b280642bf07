#include "renderer/ibl/blur.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "tests/support/reference/convolution.hpp"

namespace furnace {
namespace {

using reference::Direction;
using reference::Rgb;

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

// A noisy sky over a darker ground, and a sun of one texel.
Image sunny_map(Extent extent, int sun_row, float sun) {
  std::mt19937 random(7);
  Image map = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  float* out = map.samples<float>().data();
  for (int j = 0; j < extent.height; ++j) {
    for (int i = 0; i < extent.width; ++i, out += 3)
      for (int c = 0; c < 3; ++c)
        out[c] = float((j < extent.height / 2 ? 1 : 0.1) * (0.5 + random() / 4294967296.0) * (1 + c));
  }
  float* texel = map.samples<float>().data() + (std::size_t(sun_row) * extent.width + 3) * 3;
  for (int c = 0; c < 3; ++c) texel[c] = sun * float(1 - 0.2 * c);
  return map;
}

// The integral over the sphere of the map, constant over each texel, times the density: each texel in parts of a third of
// a sigma, with 2 x 2 Gauss nodes in each.
Rgb blurred_sum(const Image& map, double sigma, Direction d) {
  const double kappa = 1 / (sigma * sigma);
  const double scale = kappa / (2 * kPi * -std::expm1(-2 * kappa));
  const double cell = kPi / map.extent.height, cell_phi = 2 * kPi / map.extent.width;
  const int parts = std::max(1, int(std::ceil(cell / (0.35 * sigma))));
  const double reach = 8 * sigma + 2 * cell;
  Rgb sum{};
  for (int j = 0; j < map.extent.height; ++j) {
    if (std::abs(cell * (j + 0.5) - d.theta) > reach) continue;
    for (int i = 0; i < map.extent.width; ++i) {
      const Direction centre = reference::texel_direction(map.extent, i, j);
      const auto [x, y, z] = centre.unit();
      const auto [dx, dy, dz] = d.unit();
      if (reach < kPi && x * dx + y * dy + z * dz < std::cos(reach)) continue;
      double weight = 0;
      for (int part = 0; part < 4 * parts * parts; ++part) {
        const auto node = [&](int k) {
          return (k / 2 + 0.5 + (k % 2 ? 0.5 : -0.5) / std::sqrt(3.0)) / parts - 0.5;
        };
        const double theta = centre.theta + cell * node(part / (2 * parts));
        const double phi = centre.phi + cell_phi * node(part % (2 * parts));
        const double s = std::sin((theta - d.theta) / 2), t = std::sin((phi - d.phi) / 2);
        weight +=
            std::sin(theta) * std::exp(-2 * kappa * (s * s + std::sin(theta) * std::sin(d.theta) * t * t));
      }
      weight *= scale * cell * cell_phi / (4 * parts * parts);
      const Rgb value = reference::texel_value(map, i, j);
      for (int c = 0; c < 3; ++c) sum[c] += weight * value[c];
    }
  }
  return sum;
}

Image blurred(const Image& map, double sigma, int threads = 2) {
  WorkerPool pool(threads);
  return blurred_environment(map, sigma, pool, {});
}

// Keys's cubic through 4 x 4 texels, as a careful reader of the result would take them.
Rgb read_cubic(const Image& map, Direction d) {
  const auto [width, height] = map.extent;
  const auto weight = [](double x) {
    x = std::abs(x);
    return x < 1 ? 1 + x * x * (1.5 * x - 2.5) : x < 2 ? 2 + x * (-4 + x * (2.5 - 0.5 * x)) : 0;
  };
  const double column = (d.phi / (2 * kPi) + 0.5) * width - 0.5, row = d.theta / kPi * height - 0.5;
  Rgb sum{};
  for (int b = -1; b <= 2; ++b) {
    for (int a = -1; a <= 2; ++a) {
      int i = int(std::floor(column)) + a, j = int(std::floor(row)) + b;
      const double w = weight(column - i) * weight(row - j);
      if (j < 0 || j >= height) i += width / 2, j = j < 0 ? -1 - j : 2 * height - 1 - j;
      const Rgb value = reference::texel_value(map, (i % width + width) % width, j);
      for (int c = 0; c < 3; ++c) sum[c] += w * value[c];
    }
  }
  return sum;
}

// Everywhere and around the sun, where it falls by eleven orders of magnitude.
std::vector<Direction> directions_around(Direction sun, double sigma) {
  std::vector<Direction> all = reference::spread_directions(16);
  for (double distance = 0; distance < 6; distance += 0.5) {
    for (double turn : {0.0, 1.0, 4.0}) {
      const double theta = sun.theta + distance * sigma * std::cos(turn);
      const double phi = sun.phi + distance * sigma * std::sin(turn) / std::sin(sun.theta);
      if (theta > 0 && theta < kPi && std::abs(phi) < kPi) all.push_back({theta, phi});
    }
  }
  return all;
}

// The nearest texel's centre.
Direction texel_at(Extent extent, Direction d, int& i, int& j) {
  i = std::clamp(int((d.phi / (2 * kPi) + 0.5) * extent.width), 0, extent.width - 1);
  j = std::clamp(int(d.theta / kPi * extent.height), 0, extent.height - 1);
  return reference::texel_direction(extent, i, j);
}

void expect_blur(const Image& map, int sun_row, double sigma) {
  SCOPED_TRACE(testing::Message() << map.extent.width << " px, sigma " << sigma / kDegree << " degrees");
  const Image image = blurred(map, sigma);
  EXPECT_LE(image.extent.height, map.extent.height);
  EXPECT_EQ(image.extent.width, 2 * image.extent.height);
  const Direction sun = reference::texel_direction(map.extent, 3, sun_row);
  std::vector<Rgb> computed, cubic, expected, between;
  for (const Direction& d : directions_around(sun, std::max(sigma, kPi / map.extent.height))) {
    int i = 0, j = 0;
    expected.push_back(blurred_sum(map, sigma, texel_at(image.extent, d, i, j)));
    computed.push_back(reference::texel_value(image, i, j));
    cubic.push_back(read_cubic(image, d));
    between.push_back(blurred_sum(map, sigma, d));
  }
  EXPECT_LE(reference::relative_rmse(computed, expected), 2e-4);
  // Where the grid is the blur's own and not the map's, which may be too coarse for it.
  if (image.extent.height < map.extent.height) {
    EXPECT_LE(reference::relative_rmse(cubic, between), 1e-3);
  }
}

TEST(Blur, AgreesWithSumsInDoublePrecision) {
  const Image fine = sunny_map({1024, 512}, 100, 2e5f);
  for (double degrees : {0.3, 1.0, 3.0}) expect_blur(fine, 100, degrees * kDegree);
  const Image coarse = sunny_map({256, 128}, 30, 2e5f);
  for (double degrees : {1.0, 3.0, 8.0, 30.0, 90.0, 180.0}) expect_blur(coarse, 30, degrees * kDegree);
  const Image zenith = sunny_map({192, 96}, 0, 2e5f);
  for (double degrees : {2.0, 8.0, 30.0}) expect_blur(zenith, 0, degrees * kDegree);
}

TEST(Blur, NoneIsTheMapItself) {
  const Image map = sunny_map({64, 32}, 5, 2e5f);
  EXPECT_EQ(blurred(map, 0).pixels, map.pixels);
  EXPECT_EQ(blurred(map, 1e-9).pixels, map.pixels);
}

// Below the texels the second moment of what a texel spreads grows with sigma^2, and nothing jumps.
TEST(Blur, GrowsOutOfTheMap) {
  const Image map = sunny_map({128, 64}, 20, 2e5f);
  const double cell = kPi / 64;
  const auto sun_of = [&](double rows) {
    return reference::texel_value(blurred(map, rows * cell), 3, 20)[0];
  };
  double before = reference::texel_value(map, 3, 20)[0];
  for (double rows = 0.025; rows < 1.5; rows += 0.025) {
    const double value = sun_of(rows);
    EXPECT_LT(value, before);
    // The sun itself falls by 1.9 of its radiance a row where it falls fastest.
    EXPECT_LT(before - value, 0.06 * 2e5) << "a jump at " << rows;
    before = value;
  }
}

TEST(Blur, KeepsConstantsEnergyAndSigns) {
  Image even = make_image({128, 64}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (float& sample : even.samples<float>()) sample = 3;
  const Image map = sunny_map({128, 64}, 20, 2e5f);
  const Rgb mean = reference::mean_radiance(map);
  for (double sigma : {0.01, 0.04, 0.1, 0.3, 1.0, kPi}) {
    SCOPED_TRACE(sigma);
    const Image constant = blurred(even, sigma);
    for (float sample : constant.samples<float>()) ASSERT_NEAR(sample, 3, 3e-5);
    const Image image = blurred(map, sigma);
    for (float sample : image.samples<float>()) ASSERT_GE(sample, 0.05f) << "ringing";
    for (int c = 0; c < 3; ++c)  // the centres' own sum is a quadrature of a narrow sun
      EXPECT_NEAR(reference::mean_radiance(image)[c] / mean[c], 1, sigma < 0.1 ? 1e-2 : 1e-4);
  }
}

TEST(Blur, DoesNotDependOnTheNumberOfThreads) {
  const Image map = sunny_map({128, 64}, 20, 2e5f);
  for (double sigma : {0.03, 0.2}) EXPECT_EQ(blurred(map, sigma, 1).pixels, blurred(map, sigma, 4).pixels);
}

TEST(Blur, StopsAtTheDeadline) {
  WorkerPool pool(1);
  EXPECT_THROW(
      blurred_environment(sunny_map({128, 64}, 20, 1), 0.1, pool, Deadline(std::chrono::milliseconds(0))),
      Error);
}

}  // namespace
}  // namespace furnace
