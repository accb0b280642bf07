// The hemisphere around each direction of the result is cut into quadrilaterals:
//
//   | irradiance = sum over quads of L(centre) cos(theta of the centre) area |
//
// A quad is several texels large, so L at its centre is read from a map that was averaged to the size of the quads. What
// stands far above the mean (a sun of 1e5) would be blurred over the horizon by that, where it costs tens of percent of a
// dark side; there the map's own texels, cut into equal parts, are the quads.
#include "renderer/ibl/riemann.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/base/check.hpp"

namespace furnace {

namespace {

using Vec3 = std::array<double, 3>;

constexpr double kPi = std::numbers::pi;
// What exceeds so many times the mean is summed over its own texels: at most 1/8 of the sphere, and what remains has too
// little contrast for its blur to matter.
constexpr double kPeaksAbove = 8;
// Parts of a bright texel to a polar step: the error where a sun sets falls with the part's size, and is then that of the
// texel's shape.
constexpr double kPartsPerStep = 4;
constexpr double kTermCost_us = 0.002;

Vec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Of the quadrilateral with corners at two polar angles and at azimuths 0 and `width`.
double quad_area(double theta0, double theta1, double width) {
  const Vec3 a = direction(theta0, 0), b = direction(theta0, width);
  const Vec3 c = direction(theta1, width), d = direction(theta1, 0);
  return spherical_triangle_area(a, d, c) + spherical_triangle_area(a, c, b);
}

// Sums and maps in double, RGB interleaved.
struct Map {
  int width = 0;
  int height = 0;
  std::vector<double> values;

  double* at(int i, int j) { return values.data() + (std::size_t(j) * width + i) * 3; }
  const double* at(int i, int j) const { return values.data() + (std::size_t(j) * width + i) * 3; }
};

double band(double row0, double row1, int height) {  // solid angle between two rows over 2 pi
  return 2 * std::sin(kPi * (row1 - row0) / (2 * height)) * std::sin(kPi * (row0 + row1) / (2 * height));
}

Vec3 mean_radiance(const Image& map) {
  const float* in = map.samples<float>().data();
  Vec3 sum{};
  for (int j = 0; j < map.extent.height; ++j) {
    const double weight = band(j, j + 1, map.extent.height) / (2.0 * map.extent.width);
    for (int i = 0; i < map.extent.width; ++i, in += 3)
      for (int c = 0; c < 3; ++c) sum[c] += weight * in[c];
  }
  return sum;
}

// The parts of [k, k + 1) / count that lie in each of `cells` equal cells, in cells.
template <class Visit>
void split(int k, int count, int cells, Visit&& visit) {
  const double low = double(k) * cells / count, high = double(k + 1) * cells / count;
  for (int cell = static_cast<int>(low); cell < cells && cell < high; ++cell) {
    const double from = std::max(low, double(cell)), to = std::min(high, cell + 1.0);
    if (to > from) visit(cell, from, to);
  }
}

// Means over the solid angle of other texels, of the map up to `ceiling`.
Map averaged(const Image& map, const Vec3& ceiling, Extent extent) {
  const int width = map.extent.width, height = map.extent.height;
  Map mean{extent.width, extent.height, {}};
  mean.values.resize(std::size_t(mean.width) * mean.height * 3);
  const float* texels = map.samples<float>().data();
  for (int j = 0; j < height; ++j) {
    split(j, height, mean.height, [&](int row, double top, double bottom) {
      const double weight = band(top, bottom, mean.height) / band(row, row + 1, mean.height);
      for (int i = 0; i < width; ++i) {
        const float* in = texels + (std::size_t(j) * width + i) * 3;
        split(i, width, mean.width, [&](int column, double left, double right) {
          double* out = mean.at(column, row);
          for (int c = 0; c < 3; ++c) out[c] += weight * (right - left) * std::min(double{in[c]}, ceiling[c]);
        });
      }
    });
  }
  return mean;
}

// Quads of their own: a unit direction, and radiance above the ceiling times area.
struct Peak {
  Vec3 direction;
  Vec3 flux;
};

std::vector<Peak> peaks_above(const Image& map, const Vec3& ceiling, double largest_part_rad) {
  const int width = map.extent.width, height = map.extent.height;
  const int parts = std::max(1, static_cast<int>(std::ceil(kPi / height / largest_part_rad)));
  const double step_theta = kPi / height / parts, step_phi = 2 * kPi / width / parts;
  std::vector<Peak> peaks;
  const float* in = map.samples<float>().data();
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i, in += 3) {
      Vec3 excess;
      for (int c = 0; c < 3; ++c) excess[c] = std::max(0.0, in[c] - ceiling[c]);
      if (excess == Vec3{}) continue;
      for (int part = 0; part < parts * parts; ++part) {
        const double theta = step_theta * (j * parts + part / parts);
        const double phi = step_phi * (i * parts + part % parts + 0.5) - kPi;
        const double area = quad_area(theta, theta + step_theta, step_phi);
        peaks.push_back({direction(theta + 0.5 * step_theta, phi),
                         {excess[0] * area, excess[1] * area, excess[2] * area}});
      }
    }
  }
  return peaks;
}

// What each texel of `map` counts in the direction (theta, phi): area cos(theta) of the quads whose centres read it,
// bilinear as sample_equirect. (The texel that holds a centre would jump as the quads turn.)
std::vector<double> texel_weights(double theta, double phi, Extent quads, const std::vector<double>& areas,
                                  const Map& map) {
  const Vec3 n = direction(theta, phi), t = direction(theta + kPi / 2, phi),
             b = {-std::sin(phi), 0, std::cos(phi)};
  std::vector<double> weights(std::size_t(map.width) * map.height);
  const auto read = [&](const Vec3& centre, double weight) {
    const double row = std::atan2(std::hypot(centre[0], centre[2]), centre[1]) / kPi * map.height - 0.5;
    const double column = (std::atan2(centre[2], centre[0]) / (2 * kPi) + 0.5) * map.width - 0.5;
    const int i = static_cast<int>(std::floor(column)), j = static_cast<int>(std::floor(row));
    for (int k = 0; k < 2; ++k) {
      const double w = weight * (k == 0 ? j + 1 - row : row - j);
      const bool over = j + k < 0 || j + k >= map.height;  // a pole: half a turn away
      double* texels = weights.data() + std::size_t(over ? j + 1 - k : j + k) * map.width;
      const int left = i + map.width + (over ? map.width / 2 : 0);
      texels[left % map.width] += w * (i + 1 - column);
      texels[(left + 1) % map.width] += w * (column - i);
    }
  };
  for (int ring = 0; ring < quads.height; ++ring) {
    const double polar = kPi / 2 * (ring + 0.5) / quads.height;
    for (int k = 0; k < quads.width; ++k) {
      const Vec3 local = direction(polar, 2 * kPi * (k + 0.5) / quads.width);
      Vec3 centre;
      for (int c = 0; c < 3; ++c) centre[c] = local[1] * n[c] + local[0] * t[c] + local[2] * b[c];
      read(centre, areas[ring] * std::cos(polar));
    }
  }
  return weights;
}

// The map under weights that were turned by `shift` of its columns.
Vec3 weighted_sum(const std::vector<double>& weights, int shift, const Map& map) {
  Vec3 sum{};
  const auto add = [&](const double* w, const double* in, int count) {
    for (int i = 0; i < count; ++i, in += 3)
      for (int c = 0; c < 3; ++c) sum[c] += w[i] * in[c];
  };
  for (int j = 0; j < map.height; ++j) {
    const double* row = weights.data() + std::size_t(j) * map.width;
    add(row, map.at(shift, j), map.width - shift);
    add(row + map.width - shift, map.at(0, j), shift);
  }
  return sum;
}

void add_peaks(const std::vector<Peak>& peaks, const Vec3& n, Vec3& sum) {
  for (const Peak& peak : peaks) {
    const double cosine = std::max(0.0, dot(n, peak.direction));
    for (int c = 0; c < 3; ++c) sum[c] += cosine * peak.flux[c];
  }
}

}  // namespace

// Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle": the spherical excess alpha + beta + gamma - pi as
//   | tan(area / 2) = |a . (b x c)| / (1 + a.b + b.c + c.a) |
// The angles themselves add up to nearly pi in a small triangle. a . (b x c) = a . ((b - a) x (c - a)).
double spherical_triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, q = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const Vec3 cross = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
  return 2 * std::atan2(std::abs(dot(a, cross)), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

std::vector<double> hemisphere_quad_areas(Extent quads) {
  std::vector<double> areas;
  const double step = kPi / 2 / quads.height;
  for (int ring = 0; ring < quads.height; ++ring)
    areas.push_back(quad_area(step * ring, step * (ring + 1), 2 * kPi / quads.width));
  return areas;
}

Image riemann_irradiance(const Image& equirect, Extent quads, int rows, WorkerPool& pool,
                         const Deadline& deadline) {
  FURNACE_CHECK(equirect.channels == 3 && equirect.type == SampleType::kFloat32 &&
                    equirect.extent.width == 2 * equirect.extent.height,
                "not an RGB kFloat32 equirect: {} x {}", equirect.extent.width, equirect.extent.height);
  FURNACE_CHECK(quads.width >= 3 && quads.height >= 1, "{} x {} quads", quads.width, quads.height);
  Image result = make_image({2 * rows, rows}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  const std::vector<double> areas = hemisphere_quad_areas(quads);
  Vec3 ceiling = mean_radiance(equirect);
  for (double& c : ceiling) c *= kPeaksAbove;
  // A quad at the rim is as wide as a texel of a map of quads.height rows, and half as high. A column of the result is a
  // whole number of texels, so that all columns of a row see the same weights, turned.
  const int columns = 2 * rows, map_rows = std::min(quads.height, equirect.extent.height);
  const int texels_per_column = (2 * map_rows + columns - 1) / columns;
  const Map map = averaged(equirect, ceiling, {columns * texels_per_column, map_rows});
  const std::vector<Peak> peaks = peaks_above(equirect, ceiling, kPi / 2 / quads.height / kPartsPerStep);

  const double cost_us = columns * kTermCost_us * double(map.values.size() / 3 + peaks.size());
  pool.parallel_for(rows, cost_us, [&](std::size_t row) {
    check_deadline(deadline, "environment: Riemann sums");
    const double theta = kPi * (row + 0.5) / rows;
    const auto phi = [&](int i) { return 2 * kPi * ((i + 0.5) / columns - 0.5); };
    const std::vector<double> weights = texel_weights(theta, phi(0), quads, areas, map);
    float* out = result.samples<float>().data() + row * columns * 3;
    for (int i = 0; i < columns; ++i) {
      Vec3 sum = weighted_sum(weights, i * texels_per_column, map);
      add_peaks(peaks, direction(theta, phi(i)), sum);
      for (int c = 0; c < 3; ++c) *out++ = static_cast<float>(sum[c] / kPi);
    }
  });
  return result;
}

}  // namespace furnace
