// Pharr, Jakob and Humphreys 2016, "Physically Based Rendering", section 14.2.4: rows, then columns, by inversion of the
// cumulated luminance; here times the cosine to the plane's normal.
#include "renderer/ibl/light_directions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace furnace {
namespace {

using std::numbers::pi;

struct Color {
  double r = 0, g = 0, b = 0;

  double luminance() const { return 0.2126 * r + 0.7152 * g + 0.0722 * b; }
};

// Row j of the map.
std::vector<Color> row_of(const Image& map, int j) {
  const auto width = std::size_t(map.extent.width);
  const auto halves = map.samples<std::uint16_t>().subspan(std::size_t(j) * width * 4, width * 4);
  std::vector<float> samples(halves.size());
  float_from_half(halves, samples);
  std::vector<Color> row;
  for (std::size_t i = 0; i < samples.size(); i += 4)
    row.push_back({samples[i], samples[i + 1], samples[i + 2]});
  return row;
}

// Irradiance that a texel of row j gives for a radiance of 1: the cosine's integral over it.
double row_weight(Extent extent, int j) {
  const auto sine2 = [&](int edge) { return std::pow(std::sin(pi * edge / extent.height), 2); };
  return 0.5 * (sine2(j + 1) - sine2(j)) * 2 * pi / extent.width;
}

// Where `target` of the total is reached: an index, and how far through it, [0, 1).
struct Place {
  std::size_t index = 0;
  double within = 0;
};

Place find(const std::vector<double>& cumulated, double target) {
  const auto after = std::upper_bound(cumulated.begin(), cumulated.end() - 1, target);
  const auto index = std::size_t(after - cumulated.begin());
  const double before = index == 0 ? 0 : cumulated[index - 1];
  const double own = *after - before;
  return {index, own > 0 ? std::clamp((target - before) / own, 0.0, 1.0) : 0.5};
}

std::vector<double> cumulate(std::vector<double> values) {
  double sum = 0;
  for (double& value : values) value = sum += value;
  return values;
}

// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": any beginning of it is well spread; `step` is a
// power of kStep, one a dimension.
constexpr double kStep = 1 / 1.32471795724474602596;

double quasi_random(int i, double step) {
  const double x = 0.5 + (i + 1) * step;
  return x - std::floor(x);
}

}  // namespace

std::vector<LightDirection> ground_light(const Image& equirect, int count) {
  const Extent extent = equirect.extent;
  const int rows = extent.height / 2;
  std::vector<double> row_light;
  for (int j = 0; j < rows; ++j) {
    double sum = 0;
    for (const Color& color : row_of(equirect, j)) sum += color.luminance();
    row_light.push_back(sum * row_weight(extent, j));
  }
  const std::vector<double> cumulated_rows = cumulate(std::move(row_light));
  if (cumulated_rows.empty() || !(cumulated_rows.back() > 0)) return {};

  struct Row {
    std::vector<Color> colors;
    std::vector<double> cumulated;
  };
  std::map<std::size_t, Row> met;
  std::vector<LightDirection> lights;
  for (int k = 0; k < count; ++k) {
    const Place place = find(cumulated_rows, quasi_random(k, kStep) * cumulated_rows.back());
    Row& row = met[place.index];
    if (row.colors.empty()) {
      row.colors = row_of(equirect, int(place.index));
      std::vector<double> light;
      for (const Color& color : row.colors) light.push_back(color.luminance());
      row.cumulated = cumulate(std::move(light));
    }
    const Place column = find(row.cumulated, quasi_random(k, kStep * kStep) * row.cumulated.back());
    const double theta = pi * (double(place.index) + place.within) / extent.height;
    const double phi = 2 * pi * ((double(column.index) + column.within) / extent.width - 0.5);
    const Color& color = row.colors[column.index];
    const double luminance = color.luminance();
    LightDirection light;
    light.towards = {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
    const double share = cumulated_rows.back() / (luminance * count);
    light.irradiance = {color.r * share, color.g * share, color.b * share};
    lights.push_back(light);
  }
  return lights;
}

std::vector<LightDirection> ground_light(const std::array<double, 3>& towards,
                                         const std::array<double, 3>& irradiance, double angular_radius_rad,
                                         int count) {
  // Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
  const auto [x, y, z] = towards;
  const double sign = std::copysign(1.0, z), a = -1 / (sign + z), b = x * y * a;
  const std::array<double, 3> across{1 + sign * x * x * a, sign * b, -sign * x};
  const std::array<double, 3> along{b, sign + y * y * a, -y};
  std::vector<LightDirection> lights;
  double cosines = 0;
  for (int k = 0; k < count; ++k) {
    const double radius = std::tan(angular_radius_rad) * std::sqrt(quasi_random(k, kStep));
    const double angle = 2 * pi * quasi_random(k, kStep * kStep);
    LightDirection light;
    double length2 = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      light.towards[i] = towards[i] + radius * (std::cos(angle) * across[i] + std::sin(angle) * along[i]);
      length2 += light.towards[i] * light.towards[i];
    }
    for (double& component : light.towards) component /= std::sqrt(length2);
    const double cosine = light.towards[1];
    if (cosine <= 0) continue;
    cosines += cosine;
    for (std::size_t c = 0; c < 3; ++c) light.irradiance[c] = irradiance[c] * cosine;
    lights.push_back(light);
  }
  const double scale = std::max(towards[1], 0.0) / std::max(cosines, 1e-12);
  for (LightDirection& light : lights) {
    for (double& share : light.irradiance) share *= scale;
  }
  if (scale == 0) lights.clear();
  return lights;
}

std::vector<LightDirection> joined_by_light(std::vector<std::vector<LightDirection>> sources, int count) {
  std::vector<double> light;
  for (const auto& source : sources) {
    double sum = 0;
    for (const LightDirection& d : source)
      sum += Color{d.irradiance[0], d.irradiance[1], d.irradiance[2]}.luminance();
    light.push_back(sum);
  }
  double total = 0;
  for (const double one : light) total += one;
  std::vector<LightDirection> joined;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    std::vector<LightDirection>& source = sources[i];
    const auto wanted = std::size_t(std::lround(total > 0 ? light[i] / total * count : 0));
    if (light[i] <= 0 || source.empty()) continue;
    // A beginning of the list, each standing for more.
    const std::size_t kept = std::clamp<std::size_t>(wanted, 1, source.size());
    double sum = 0;
    for (std::size_t k = 0; k < kept; ++k) {
      const auto& e = source[k].irradiance;
      sum += Color{e[0], e[1], e[2]}.luminance();
    }
    for (std::size_t k = 0; k < kept; ++k) {
      for (double& share : source[k].irradiance) share *= light[i] / sum;
      joined.push_back(source[k]);
    }
  }
  return joined;
}

}  // namespace furnace
