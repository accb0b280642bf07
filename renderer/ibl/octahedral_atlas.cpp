#include "renderer/ibl/octahedral_atlas.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/lanes.hpp"
#include "renderer/ibl/tile_resampler.hpp"

namespace furnace {

namespace {

constexpr int kBorder = 1;  // px
constexpr int kSmallestTile = 64;
constexpr double kTexelsPerAlpha = 7;      // side of a tile times alpha: the error of bilinear reading
constexpr double kTexelsPerColumn = 0.75;  // side of a tile per column of the HDRI
constexpr double kKinkTile = 192;
constexpr int kLargestTile = 1024;
constexpr float kLargestHalf = 65504;

// The kernel and the texels of the HDRI blur together; the finer of the two counts for little. Rough levels have a kink
// where a sun sets, the stronger the rougher.
int tile_side(double alpha, int map_columns) {
  const double blurred = 1 / std::hypot(alpha / kTexelsPerAlpha, 1 / (kTexelsPerColumn * map_columns));
  const double side = std::max(blurred, kKinkTile * std::cbrt(alpha));
  return std::clamp(static_cast<int>(std::ceil(side / 8)) * 8, kSmallestTile, kLargestTile);
}

// Lays squares, largest first, as low as they go under a skyline of the given width; returns the height, or nothing when
// one does not fit below `highest`. (Jylanki 2010, "A Thousand Ways to Pack the Bin": skyline, bottom-left.)
std::optional<int> place_tiles(const std::vector<AtlasTile*>& tiles, int width, int highest) {
  std::vector<int> skyline(width, 0);  // px, by column
  for (AtlasTile* tile : tiles) {
    const int side = tile->inner + 2 * kBorder;
    int best_x = -1, best_y = std::numeric_limits<int>::max();
    for (int x = 0; x + side <= width; ++x) {
      if (x > 0 && skyline[x] == skyline[x - 1]) continue;  // only where the skyline steps
      const int y = *std::max_element(skyline.begin() + x, skyline.begin() + x + side);
      if (y < best_y) best_x = x, best_y = y;
    }
    if (best_x < 0 || best_y + side > highest) return std::nullopt;
    tile->x = best_x + kBorder;
    tile->y = best_y + kBorder;
    std::fill_n(skyline.begin() + best_x, side, best_y + side);
  }
  return *std::max_element(skyline.begin(), skyline.end());
}

// The width with the least area.
Extent place_tiles(const std::vector<AtlasTile*>& tiles) {
  Extent best;
  const int widest = tiles.front()->inner + 2 * kBorder;
  // Three times the widest tile is enough for the tiles of a large map; a small map's are nearly equal and need more.
  for (int limit = 3 * widest; best.width == 0; limit += widest) {
    for (int width = widest; width <= limit; width += 8) {
      const int highest =
          best.width == 0 ? limit : std::min<int>(limit, static_cast<int>((best.area() - 1) / width));
      if (const std::optional<int> height = place_tiles(tiles, width, highest)) best = {width, *height};
    }
  }
  place_tiles(tiles, best.width, best.height);
  return best;
}

void copy_borders(const AtlasTile& tile, Image& atlas) {
  const int inner = tile.inner;
  const auto halves = atlas.samples<std::uint16_t>();
  const auto at = [&](int i, int j) {
    return halves.data() + (std::size_t(tile.y + j) * atlas.extent.width + tile.x + i) * 4;
  };
  const auto copy_border = [&](int i, int j) {
    const TexelIndex from = fold_octahedral(i, j, inner);
    std::copy_n(at(from.i, from.j), 4, at(i, j));
  };
  for (int k = -1; k <= inner; ++k) {
    copy_border(k, -1);
    copy_border(k, inner);
    copy_border(-1, k);
    copy_border(inner, k);
  }
}

}  // namespace

OctahedralUv octahedral_from_direction(double x, double y, double z) {
  const double length = std::abs(x) + std::abs(y) + std::abs(z);
  double u = x / length, v = z / length;
  if (y < 0) {
    const double folded = std::copysign(1 - std::abs(v), u);
    v = std::copysign(1 - std::abs(u), v);
    u = folded;
  }
  return {0.5 + 0.5 * u, 0.5 + 0.5 * v};
}

std::array<double, 3> direction_from_octahedral(double u, double v) {
  double x = 2 * u - 1, z = 2 * v - 1;
  const double y = 1 - std::abs(x) - std::abs(z);
  if (y < 0) {
    const double unfolded = std::copysign(1 - std::abs(z), x);
    z = std::copysign(1 - std::abs(x), z);
    x = unfolded;
  }
  const double length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

OctahedralAtlas make_octahedral_atlas(const BakedEnvironment& baked, WorkerPool& pool) {
  OctahedralAtlas atlas;
  const int columns = std::max(baked.radiance->extent.width, baked.levels.front().equirect.extent.width);
  float peak = largest_sample(baked.irradiance.samples<float>());
  for (const BakedLevel& level : baked.levels) {
    const double alpha = level.perceptual_roughness * level.perceptual_roughness;
    atlas.level_roughness.push_back(level.perceptual_roughness);
    atlas.level_tiles.push_back({0, 0, tile_side(alpha, columns)});
    peak = std::max(peak, largest_sample(level.equirect.samples<float>()));
  }
  atlas.irradiance_tile.inner = tile_side(1, columns);
  // A factor of two is left for what interpolation adds.
  if (peak > 0) atlas.scale = std::exp2(std::floor(std::log2(kLargestHalf / (2.0 * peak))));

  std::vector<AtlasTile*> tiles = {&atlas.irradiance_tile};
  for (AtlasTile& tile : atlas.level_tiles) tiles.push_back(&tile);
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const AtlasTile* a, const AtlasTile* b) { return a->inner > b->inner; });
  atlas.texels = make_image(place_tiles(tiles), 4, SampleType::kFloat16, ColorSpace::kLinear);

  TileResampler resampler(pool);
  const auto fill = [&](const Image& equirect, const AtlasTile& tile) {
    resampler.resample(equirect, static_cast<float>(atlas.scale), {atlas.texels, tile.x, tile.y, tile.inner});
    copy_borders(tile, atlas.texels);
  };
  for (std::size_t i = 0; i < baked.levels.size(); ++i) fill(baked.levels[i].equirect, atlas.level_tiles[i]);
  fill(baked.irradiance, atlas.irradiance_tile);
  return atlas;
}

}  // namespace furnace
