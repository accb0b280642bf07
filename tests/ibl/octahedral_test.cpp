#include "renderer/ibl/octahedral_atlas.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/base/worker_pool.hpp"
#include "tests/support/reference/convolution.hpp"

namespace furnace {
namespace {

using reference::Direction;
using reference::Rgb;

Image painted(Extent extent, double (*value)(double x, double y, double z)) {
  Image image = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  float* out = image.samples<float>().data();
  for (int j = 0; j < extent.height; ++j) {
    for (int i = 0; i < extent.width; ++i, out += 3) {
      const auto [x, y, z] = reference::texel_direction(extent, i, j).unit();
      out[0] = out[1] = out[2] = static_cast<float>(value(x, y, z));
    }
  }
  return image;
}

// Every map of the environment is `image`: the atlas alone is under test.
BakedEnvironment all_levels(const Image& image) {
  BakedEnvironment baked;
  baked.radiance = std::make_shared<Image>(image);
  for (double roughness : ggx_level_roughness())
    if (roughness > 0) baked.levels.push_back({roughness, image});
  baked.irradiance = image;
  return baked;
}

TEST(Octahedron, RoundTrip) {
  for (const Direction& d : reference::spread_directions(1000)) {
    const auto [x, y, z] = d.unit();
    const OctahedralUv uv = octahedral_from_direction(x, y, z);
    EXPECT_GE(std::min(uv.u, uv.v), 0);
    EXPECT_LE(std::max(uv.u, uv.v), 1);
    const auto [rx, ry, rz] = direction_from_octahedral(uv.u, uv.v);
    EXPECT_NEAR(rx, x, 1e-14);
    EXPECT_NEAR(ry, y, 1e-14);
    EXPECT_NEAR(rz, z, 1e-14);
  }
}

TEST(Octahedron, Axes) {
  const auto expect_uv = [](double x, double y, double z, double u, double v) {
    const OctahedralUv uv = octahedral_from_direction(x, y, z);
    EXPECT_DOUBLE_EQ(uv.u, u);
    EXPECT_DOUBLE_EQ(uv.v, v);
  };
  expect_uv(0, 1, 0, 0.5, 0.5);
  expect_uv(1, 0, 0, 1, 0.5);
  expect_uv(-1, 0, 0, 0, 0.5);
  expect_uv(0, 0, 1, 0.5, 1);
  expect_uv(0, 0, -1, 0.5, 0);
}

TEST(Atlas, KeepsASmoothMapEverywhere) {
  WorkerPool pool(1);
  const auto smooth = [](double x, double y, double z) { return 2 + x * y + 0.5 * z - 0.7 * y * z * z; };
  const BakedEnvironment baked = all_levels(painted({256, 128}, smooth));
  const OctahedralAtlas atlas = make_octahedral_atlas(baked, pool);
  ASSERT_EQ(atlas.level_tiles.size(), baked.levels.size());
  std::vector<Direction> directions = reference::spread_directions(2000);
  for (double phi = -3.1; phi < 3.1; phi += 0.1)  // the fold, the seam's ends and the poles
    for (double theta : {1e-4, 1.5707, 1.5709, 3.1415}) directions.push_back({theta, phi});
  for (const AtlasTile& tile : atlas.level_tiles) {
    // Bilinear reading on 64 texels a side errs by less than 0.5 % of this map's range; halves by 0.05 %.
    for (const Direction& d : directions) {
      const auto [x, y, z] = d.unit();
      EXPECT_NEAR(reference::read_tile(atlas, tile, d)[1], smooth(x, y, z), 0.012) << "side " << tile.inner;
    }
  }
}

TEST(Atlas, BordersContinueTheSphere) {
  WorkerPool pool(1);
  const BakedEnvironment baked = all_levels(
      painted({128, 64}, [](double x, double y, double z) { return std::exp(3 * x - 2 * y * z) + 1; }));
  const OctahedralAtlas atlas = make_octahedral_atlas(baked, pool);
  const auto halves = atlas.texels.samples<std::uint16_t>();
  const auto at = [&](const AtlasTile& tile, int i, int j) {
    return halves[(std::size_t(tile.y + j) * atlas.texels.extent.width + tile.x + i) * 4];
  };
  for (const AtlasTile& tile : atlas.level_tiles) {
    const int n = tile.inner;
    for (int k = 0; k < n; ++k) {
      EXPECT_EQ(at(tile, -1, k), at(tile, 0, n - 1 - k));
      EXPECT_EQ(at(tile, n, k), at(tile, n - 1, n - 1 - k));
      EXPECT_EQ(at(tile, k, -1), at(tile, n - 1 - k, 0));
      EXPECT_EQ(at(tile, k, n), at(tile, n - 1 - k, n - 1));
    }
    EXPECT_EQ(at(tile, -1, -1), at(tile, n - 1, n - 1));
    EXPECT_EQ(at(tile, n, -1), at(tile, 0, n - 1));
  }
}

TEST(Atlas, TilesDoNotOverlap) {
  WorkerPool pool(1);
  const OctahedralAtlas atlas = make_octahedral_atlas(
      all_levels(painted({1024, 512}, [](double, double, double) { return 1.0; })), pool);
  std::vector<AtlasTile> tiles = atlas.level_tiles;
  tiles.push_back(atlas.irradiance_tile);
  std::vector<int> owners(atlas.texels.extent.area(), 0);
  for (const AtlasTile& tile : tiles) {
    ASSERT_GE(std::min(tile.x, tile.y), 1);
    ASSERT_LT(tile.x + tile.inner, atlas.texels.extent.width);
    ASSERT_LT(tile.y + tile.inner, atlas.texels.extent.height);
    for (int j = -1; j <= tile.inner; ++j)
      for (int i = -1; i <= tile.inner; ++i)
        ++owners[std::size_t(tile.y + j) * atlas.texels.extent.width + tile.x + i];
  }
  EXPECT_EQ(*std::max_element(owners.begin(), owners.end()), 1);
  EXPECT_LE(atlas.texels.byte_size(), 17'000'000u);  // what a 1k environment may take on the GPU
}

TEST(Atlas, BrightestSunFitsHalfFloats) {
  WorkerPool pool(1);
  BakedEnvironment baked = all_levels(painted({64, 32}, [](double, double, double) { return 0.01; }));
  for (BakedLevel& level : baked.levels) level.equirect.samples<float>()[(10 * 64 + 20) * 3] = 3e6f;
  const OctahedralAtlas atlas = make_octahedral_atlas(baked, pool);
  EXPECT_EQ(std::exp2(std::round(std::log2(atlas.scale))), atlas.scale);
  double largest = 0;
  for (std::uint16_t half : atlas.texels.samples<std::uint16_t>()) {
    ASSERT_TRUE(std::isfinite(float_from_half(half)));
    largest = std::max(largest, double{float_from_half(half)});
  }
  EXPECT_GT(largest / atlas.scale, 1e6);  // not clamped: the tile's texels hit the cubic beside its top
}

}  // namespace
}  // namespace furnace
