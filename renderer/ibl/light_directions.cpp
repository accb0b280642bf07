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

// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": any beginning of it is well spread.
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

  constexpr double kPlastic = 1.32471795724474602596;
  struct Row {
    std::vector<Color> colors;
    std::vector<double> cumulated;
  };
  std::map<std::size_t, Row> met;
  std::vector<LightDirection> lights;
  std::array<double, 3> total{};
  for (int k = 0; k < count; ++k) {
    const Place place = find(cumulated_rows, quasi_random(k, 1 / kPlastic) * cumulated_rows.back());
    Row& row = met[place.index];
    if (row.colors.empty()) {
      row.colors = row_of(equirect, int(place.index));
      std::vector<double> light;
      for (const Color& color : row.colors) light.push_back(color.luminance());
      row.cumulated = cumulate(std::move(light));
    }
    const Place column =
        find(row.cumulated, quasi_random(k, 1 / (kPlastic * kPlastic)) * row.cumulated.back());
    const double theta = pi * (double(place.index) + place.within) / extent.height;
    const double phi = 2 * pi * ((double(column.index) + column.within) / extent.width - 0.5);
    const Color& color = row.colors[column.index];
    const double luminance = color.luminance();
    LightDirection light;
    light.towards = {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
    light.weight = {color.r / luminance, color.g / luminance, color.b / luminance};
    for (std::size_t c = 0; c < 3; ++c) total[c] += light.weight[c];
    lights.push_back(light);
  }
  for (LightDirection& light : lights) {
    for (std::size_t c = 0; c < 3; ++c) light.weight[c] = total[c] > 0 ? light.weight[c] / total[c] : 0;
  }
  return lights;
}

}  // namespace furnace
