#include "renderer/ibl/baked_environment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/ibl/octahedral_atlas.hpp"
#include "tests/support/reference/convolution.hpp"

namespace furnace {
namespace {

using reference::Direction;
using reference::Rgb;

std::shared_ptr<const BakedEnvironment> bake(std::shared_ptr<const Image> map, int threads = 2) {
  WorkerPool pool(threads);
  return bake_environment(std::move(map), {}, pool, {});
}

// A dim noisy sky over a darker ground, and a sun of one texel that outshines them by 1e5: low, high, or at the pole.
std::shared_ptr<const Image> sunny_map(Extent extent, int sun_row) {
  std::mt19937 random(11);
  auto map = std::make_shared<Image>(make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear));
  float* out = map->samples<float>().data();
  for (int j = 0; j < extent.height; ++j) {
    for (int i = 0; i < extent.width; ++i, out += 3) {
      const double noise = std::exp(1.5 * (random() / 4294967296.0 - 0.5));
      const double sky = j < extent.height / 2 ? 1.0 : 0.2;
      for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sky * noise * (0.6 + 0.2 * c));
    }
  }
  float* sun = map->samples<float>().data() + (std::size_t(sun_row) * extent.width + extent.width / 3) * 3;
  sun[0] = 1.2e5f, sun[1] = 0.9e5f, sun[2] = 0.6e5f;
  return map;
}

TEST(Bake, ConstantSkyStaysConstant) {
  auto map = std::make_shared<Image>(make_image({128, 64}, 3, SampleType::kFloat32, ColorSpace::kLinear));
  for (std::size_t k = 0; k < map->samples<float>().size(); ++k) map->samples<float>()[k] = 0.5f * (1 + k % 3);
  const auto baked = bake(map);
  const auto expect_constant = [](const Image& image, double tolerance) {
    for (std::size_t k = 0; k < image.samples<float>().size(); ++k)
      ASSERT_NEAR(image.samples<float>()[k] / (0.5 * (1 + k % 3)), 1, tolerance);
  };
  expect_constant(baked->irradiance, 1e-6);
  for (const BakedLevel& level : baked->levels) {
    // Sharp levels end their core at a finite distance: its tail is worth 1e-5 of the light.
    SCOPED_TRACE(level.perceptual_roughness);
    expect_constant(level.equirect, 5e-5);
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(baked->mean[c], 0.5 * (1 + c), 1e-6);
}

TEST(Bake, LevelsStandAsTheTableSays) {
  const std::vector<double> roughness = ggx_level_roughness();
  EXPECT_EQ(roughness.front(), 0);
  EXPECT_EQ(roughness.back(), 1);
  EXPECT_LE(roughness.size(), 32u);  // what the shader's block holds
  for (std::size_t i = 1; i < roughness.size(); ++i) {
    EXPECT_GT(roughness[i], roughness[i - 1]);
    EXPECT_GT(level_coordinate(roughness[i]), level_coordinate(roughness[i - 1]));
  }
}

void expect_levels_within_bars(const Image& map, const BakedEnvironment& baked, int texels_per_level) {
  for (std::size_t l = 0; l <= baked.levels.size(); ++l) {
    const bool irradiance = l == baked.levels.size();
    const Image& level = irradiance ? baked.irradiance : baked.levels[l].equirect;
    const double roughness = irradiance ? 1 : baked.levels[l].perceptual_roughness;
    std::vector<Rgb> computed, expected;
    for (const Direction& d : reference::spread_directions(texels_per_level)) {
      const int i = std::min(static_cast<int>((d.phi / (2 * std::numbers::pi) + 0.5) * level.extent.width),
                             level.extent.width - 1);
      const int j = std::min(static_cast<int>(d.theta / std::numbers::pi * level.extent.height), level.extent.height - 1);
      computed.push_back(reference::texel_value(level, i, j));
      expected.push_back(
          reference::prefilter(map, reference::texel_direction(level.extent, i, j), {roughness * roughness})[0]);
    }
    // The bars of the design. Sharp levels do an order better, which a change should not lose unseen.
    const double bar = irradiance ? 1e-4 : 1e-3;
    EXPECT_LE(reference::relative_rmse(computed, expected), bar) << "roughness " << roughness;
  }
}

TEST(Bake, AgreesWithDoubleSumsUnderASun) {
  const auto map = sunny_map({128, 64}, 20);
  expect_levels_within_bars(*map, *bake(map), 30);
}

TEST(Bake, AgreesWithDoubleSumsUnderASunInTheZenith) {
  const auto map = sunny_map({96, 48}, 0);
  expect_levels_within_bars(*map, *bake(map), 20);
}

TEST(Bake, KeepsEnergyAndStaysPositive) {
  for (int sun_row : {0, 7, 40}) {
    const auto map = sunny_map({128, 64}, sun_row);
    const auto baked = bake(map);
    const Rgb mean = reference::mean_radiance(*map);
    const auto check = [&](const Image& image, double roughness) {
      const Rgb level_mean = reference::mean_radiance(image);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(baked->mean[c] / mean[c], 1, 1e-6);
        // The sum over texel centres is itself a quadrature of a sun's steep image.
        EXPECT_NEAR(level_mean[c] / mean[c], 1, 1e-3) << "roughness " << roughness << " sun row " << sun_row;
      }
      for (float sample : image.samples<float>()) {
        ASSERT_TRUE(std::isfinite(sample));
        // Nothing in the map is darker than 0.2 e^-0.75 * 0.6: a lower value would be ringing.
        ASSERT_GE(sample, 0.2 * std::exp(-0.75) * 0.6) << "roughness " << roughness << " sun row " << sun_row;
      }
    };
    for (const BakedLevel& level : baked->levels) check(level.equirect, level.perceptual_roughness);
    check(baked->irradiance, 1);
  }
}

TEST(Bake, AnyRoughnessThroughTheShadersLookup) {
  const auto map = sunny_map({256, 128}, 40);
  const auto baked = bake(map);
  WorkerPool pool(2);
  const OctahedralAtlas atlas = make_octahedral_atlas(*baked, pool);
  std::vector<double> roughness, alphas;
  const std::vector<double> levels = ggx_level_roughness();
  for (std::size_t i = 1; i < levels.size(); ++i) {
    if (i > 1) roughness.push_back(0.55 * levels[i - 1] + 0.45 * levels[i]);
    roughness.push_back(levels[i]);
  }
  for (double r : roughness) alphas.push_back(r * r);
  std::vector<std::vector<Rgb>> computed(alphas.size()), expected(alphas.size());
  for (const Direction& d : reference::spread_directions(48)) {
    const std::vector<Rgb> sums = reference::prefilter(*map, d, alphas);
    for (std::size_t k = 0; k < alphas.size(); ++k) {
      computed[k].push_back(reference::read_levels(*baked, atlas, roughness[k], d));
      expected[k].push_back(sums[k]);
    }
  }
  for (std::size_t k = 0; k < alphas.size(); ++k) {
    EXPECT_LE(reference::relative_rmse(computed[k], expected[k]), roughness[k] < 0.15 ? 3e-2 : 1e-2)
        << "roughness " << roughness[k];
  }
}

TEST(Bake, DoesNotDependOnTheNumberOfThreads) {
  const auto map = sunny_map({200, 100}, 30);
  const auto one = bake(map, 1), four = bake(map, 4);
  WorkerPool pool_one(1), pool_four(4);
  for (std::size_t l = 0; l < one->levels.size(); ++l)
    EXPECT_EQ(one->levels[l].equirect.pixels, four->levels[l].equirect.pixels) << l;
  EXPECT_EQ(one->irradiance.pixels, four->irradiance.pixels);
  EXPECT_EQ(make_octahedral_atlas(*one, pool_one).texels.pixels, make_octahedral_atlas(*four, pool_four).texels.pixels);
}

TEST(Bake, StopsAtTheDeadline) {
  WorkerPool pool(1);
  try {
    bake_environment(sunny_map({64, 32}, 3), {}, pool, Deadline(std::chrono::milliseconds(0)));
    FAIL() << "baked after its time";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  }
}

TEST(SampleEquirect, ReadsTexelsBlendsAndCrossesPoles) {
  Image map = make_image({8, 4}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (int k = 0; k < 8 * 4 * 3; ++k) map.samples<float>()[k] = static_cast<float>(k);
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 8; ++i) {
      const auto [x, y, z] = reference::texel_direction(map.extent, i, j).unit();
      EXPECT_NEAR(sample_equirect(map, x, y, z)[2], map.samples<float>()[(j * 8 + i) * 3 + 2], 1e-4);
    }
  }
  // At a pole the four texels of two opposite columns meet.
  const std::array<float, 3> up = sample_equirect(map, 1e-9, 1, 1e-9);
  EXPECT_NEAR(up[0], 10.5, 1.6);
  // The seam at u = 0: half-way between the last and the first column.
  const std::array<float, 3> seam = sample_equirect(map, -std::sin(3 * std::numbers::pi / 8),
                                                    std::cos(3 * std::numbers::pi / 8), -1e-12);
  EXPECT_NEAR(seam[0], 0.5 * (24 + 24 + 21), 1e-3);
}

TEST(Bake, RealEnvironments) {
  const std::string folder = std::string(FURNACE_SOURCE_DIR) + "/../shared/data/environments/";
  int found = 0;
  for (const char* name : {"royal_esplanade_256.hdr", "pedestrian_overpass_1k.hdr"}) {
    if (!file_identity(folder + name)) continue;
    ++found;
    SCOPED_TRACE(name);
    const auto map = std::make_shared<Image>(decode_environment(Blob(read_file(folder + name, 1 << 24)), {}).equirect);
    expect_levels_within_bars(*map, *bake(map), map->extent.width > 512 ? 3 : 12);
  }
  if (found == 0) GTEST_SKIP() << "no environments in " << folder;
}

}  // namespace
}  // namespace furnace
