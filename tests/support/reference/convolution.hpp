// Judges of the environment bake, in double precision and by sums: slow, plain, and sharing nothing with the baker but the
// definition of the map.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "renderer/ibl/octahedral_atlas.hpp"

namespace furnace::reference {

using Rgb = std::array<double, 3>;

struct Direction {
  double theta = 0;  // rad, from +Y
  double phi = 0;    // rad, from +X towards +Z

  std::array<double, 3> unit() const {
    return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
  }
};

// The centre of texel (i, j) of an equirect map (baked_environment.hpp).
inline Direction texel_direction(Extent extent, int i, int j) {
  return {std::numbers::pi * (j + 0.5) / extent.height,
          2 * std::numbers::pi * ((i + 0.5) / extent.width - 0.5)};
}

inline Rgb texel_value(const Image& map, int i, int j) {
  const float* p = map.samples<float>().data() + (std::size_t(j) * map.extent.width + i) * 3;
  return {p[0], p[1], p[2]};
}

inline double d_ggx(double NoH, double alpha) {  // Walter 2007, equation 33
  const double a2 = alpha * alpha, d = NoH * NoH * (a2 - 1) + 1;
  return a2 / (std::numbers::pi * d * d);
}

// D(h) mu with h half-way between the map's direction and the light's, mu = cos of the angle between those; not normalised.
inline double prefilter_kernel(double mu, double alpha) {
  return mu <= 0 ? 0 : d_ggx(std::sqrt(0.5 * (1 + mu)), alpha) * mu;
}

inline double d_charlie(double NoH, double alpha) {  // Estevez and Kulla 2017, equation 2
  return (2 + 1 / alpha) * std::pow(1 - NoH * NoH, 0.5 / alpha) / (2 * std::numbers::pi);
}

// The same for sheen.
inline double sheen_kernel(double mu, double alpha) {
  return mu <= 0 ? 0 : d_charlie(std::sqrt(0.5 * (1 + mu)), alpha) * mu;
}

using Kernel = double (*)(double mu, double alpha);

// Its integral over the sphere: midpoints in the logarithm of the angle, where the kernel is nowhere steep.
inline double prefilter_integral(double alpha, Kernel kernel = prefilter_kernel) {
  constexpr int kSteps = 20000;
  const double low = std::log(1e-5 * alpha), high = std::log(std::numbers::pi / 2),
               step = (high - low) / kSteps;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double angle = std::exp(low + (k + 0.5) * step);
    sum += kernel(std::cos(angle), alpha) * std::sin(angle) * angle * step;
  }
  return 2 * std::numbers::pi * sum;
}

// `map`, constant over each texel, prefiltered for a direction, for several alphas at once: double sums over the texels,
// each cut as finely as the narrowest kernel asks for there, with 2 x 2 Gauss nodes in each part.
class Prefilter {
 public:
  Prefilter(const Image& map, std::vector<double> alphas, Kernel kernel = prefilter_kernel)
      : map_(map), alphas_(std::move(alphas)), kernel_(kernel) {
    for (double alpha : alphas_) integrals_.push_back(prefilter_integral(alpha, kernel));
  }

  std::vector<Rgb> operator()(Direction d) const {
    const auto [width, height] = map_.extent;
    const double cell_theta = std::numbers::pi / height;
    const double roughest = *std::max_element(alphas_.begin(), alphas_.end());
    const double near = std::cos(std::min(std::numbers::pi, (1 / kFineness + 1) * cell_theta));
    const double up = std::cos(d.theta), across = std::sin(d.theta);
    std::vector<double> columns;  // cos of the azimuth from d: of the centre and the two nodes
    for (int i = 0; i < width; ++i) {
      const double phi = texel_direction(map_.extent, i, 0).phi - d.phi, cell = 2 * std::numbers::pi / width;
      for (double offset : {0.0, node(0, 1), node(1, 1)}) columns.push_back(std::cos(phi + cell * offset));
    }
    std::vector<Rgb> sums(alphas_.size(), Rgb{});
    for (int j = 0; j < height; ++j) {
      double cos_theta[3], sin_theta[3];
      for (int k = 0; k < 3; ++k) {
        const double theta =
            texel_direction(map_.extent, 0, j).theta + (k == 0 ? 0 : cell_theta * node(k - 1, 1));
        cos_theta[k] = up * std::cos(theta);
        sin_theta[k] = std::sin(theta);
      }
      for (int i = 0; i < width; ++i) {
        const double centre = cos_theta[0] + across * sin_theta[0] * columns[3 * i];
        // The kink at mu = 0 counts in wide kernels.
        if (centre > near || (roughest > 0.1 && std::abs(centre) < 1.5 * cell_theta)) {
          add_parts(i, j, d, sums);
          continue;
        }
        for (int k = 0; k < 4; ++k) {
          const int row = 1 + k / 2;
          const double solid_angle = cell_theta * cell_theta * sin_theta[row] / 4 * (2.0 * height / width);
          add(texel_value(map_, i, j), cos_theta[row] + across * sin_theta[row] * columns[3 * i + 1 + k % 2],
              solid_angle, sums);
        }
      }
    }
    return sums;
  }

 private:
  // Part size : distance to the kernel's poles; the rule errs by its 4th power / 5.
  static constexpr double kFineness = 0.25;

  void add_parts(int i, int j, Direction d, std::vector<Rgb>& sums) const {
    const auto [width, height] = map_.extent;
    const double cell_theta = std::numbers::pi / height, cell_phi = 2 * std::numbers::pi / width;
    const double narrowest = 2 * *std::min_element(alphas_.begin(), alphas_.end());
    const Direction centre = texel_direction(map_.extent, i, j);
    const double angle = 2 * std::asin(std::min(1.0, std::sqrt(half_chord2(centre, d))));
    const double distance = std::hypot(std::max(0.0, angle - cell_theta), narrowest);
    int parts = std::clamp(static_cast<int>(std::ceil(cell_theta / (kFineness * distance))), 1, 64);
    if (std::abs(std::cos(angle)) < 1.5 * cell_theta) parts = std::max(parts, 6);
    for (int part = 0; part < 4 * parts * parts; ++part) {
      const Direction at = {centre.theta + cell_theta * node(part / (2 * parts), parts),
                            centre.phi + cell_phi * node(part % (2 * parts), parts)};
      const double solid_angle = cell_theta * cell_phi * std::sin(at.theta) / (4 * parts * parts);
      add(texel_value(map_, i, j), 1 - 2 * half_chord2(at, d), solid_angle, sums);
    }
  }
  static double half_chord2(Direction a, Direction b) {  // sin^2 of half the angle between them
    const double s = std::sin((a.theta - b.theta) / 2), t = std::sin((a.phi - b.phi) / 2);
    return s * s + std::sin(a.theta) * std::sin(b.theta) * t * t;
  }
  static double node(int k, int parts) {
    return (k / 2 + 0.5 + (k % 2 ? 0.5 : -0.5) / std::sqrt(3.0)) / parts - 0.5;
  }
  void add(const Rgb& value, double mu, double solid_angle, std::vector<Rgb>& sums) const {
    for (std::size_t k = 0; k < alphas_.size(); ++k) {
      const double weight = solid_angle * kernel_(mu, alphas_[k]) / integrals_[k];
      for (int c = 0; c < 3; ++c) sums[k][c] += weight * value[c];
    }
  }

  const Image& map_;
  std::vector<double> alphas_, integrals_;
  Kernel kernel_;
};

// What the shader reads from a tile: bilinear.
inline Rgb read_tile(const OctahedralAtlas& atlas, const AtlasTile& tile, Direction d) {
  const auto [x, y, z] = d.unit();
  const OctahedralUv uv = octahedral_from_direction(x, y, z);
  const double column = tile.x + uv.u * tile.inner - 0.5, row = tile.y + uv.v * tile.inner - 0.5;
  const int i = static_cast<int>(std::floor(column)), j = static_cast<int>(std::floor(row));
  const double s = column - i, t = row - j;
  const auto texels = atlas.texels.samples<std::uint16_t>();
  Rgb result;
  for (int c = 0; c < 3; ++c) {
    const auto at = [&](int a, int b) {
      return double{
          float_from_half(texels[(std::size_t(j + b) * atlas.texels.extent.width + i + a) * 4 + c])};
    };
    result[c] = ((1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1))) /
                atlas.scale;
  }
  return result;
}

// What the shader makes of any roughness: two neighbouring levels mixed linearly in level_coordinate.
inline Rgb read_levels(const BakedEnvironment& baked, const OctahedralAtlas& atlas, double roughness,
                       Direction d) {
  std::size_t upper = 0;
  while (upper + 1 < atlas.level_roughness.size() && atlas.level_roughness[upper] < roughness) ++upper;
  const double high = level_coordinate(atlas.level_roughness[upper]);
  const double low = upper == 0 ? 0 : level_coordinate(atlas.level_roughness[upper - 1]);
  const double w = (level_coordinate(roughness) - low) / (high - low);
  const Rgb b = read_tile(atlas, atlas.level_tiles[upper], d);
  Rgb a;
  if (upper == 0) {
    const auto [x, y, z] = d.unit();
    const std::array<float, 3> mirror = sample_equirect(*baked.radiance, x, y, z);
    std::copy(mirror.begin(), mirror.end(), a.begin());
  } else {
    a = read_tile(atlas, atlas.level_tiles[upper - 1], d);
  }
  return {a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1]), a[2] + w * (b[2] - a[2])};
}

// RMS of |c - r| / (r + 1 % of the mean r): dark sides count.
inline double relative_rmse(const std::vector<Rgb>& computed, const std::vector<Rgb>& expected) {
  double mean = 0, sum = 0;
  for (const Rgb& r : expected) mean += (r[0] + r[1] + r[2]) / (3.0 * expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    for (int c = 0; c < 3; ++c)
      sum += std::pow((computed[k][c] - expected[k][c]) / (expected[k][c] + 0.01 * mean), 2);
  }
  return std::sqrt(sum / (3.0 * expected.size()));
}

// Mean over the sphere of an equirect map's texels, weighted by their exact solid angles.
inline Rgb mean_radiance(const Image& map) {
  Rgb sum{};
  for (int j = 0; j < map.extent.height; ++j) {
    const double band = std::cos(std::numbers::pi * j / map.extent.height) -
                        std::cos(std::numbers::pi * (j + 1) / map.extent.height);
    for (int i = 0; i < map.extent.width; ++i) {
      const Rgb value = texel_value(map, i, j);
      for (int c = 0; c < 3; ++c) sum[c] += band / (2 * map.extent.width) * value[c];
    }
  }
  return sum;
}

// Evenly spread over the sphere (Swinbank and Purser 2006, "Fibonacci grids").
inline std::vector<Direction> spread_directions(int count) {
  std::vector<Direction> directions;
  for (int k = 0; k < count; ++k) {
    const double turns = k * std::numbers::phi;
    directions.push_back(
        {std::acos(1 - (2 * k + 1.0) / count), 2 * std::numbers::pi * (turns - std::floor(turns) - 0.5)});
  }
  return directions;
}

}  // namespace furnace::reference
