// Debevec 2005, "A Median Cut Algorithm for Light Probe Sampling": regions of the map are halved by their light, across their
// longer side; here to any number of cells, and each is stood for by a place in it that its light chooses, since centres lie
// in rows, whose shadows end together.
#include "renderer/ibl/light_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/image/color.hpp"

namespace furnace {
namespace {

using std::numbers::pi;

// A finer map's texels are taken together: 0.7 degrees are far below what a cell covers.
constexpr int kMostColumns = 512;
// Of the map's mean, added to the light that cells share: the dark half of a room has cells of its own, whose few would else
// stand for a glossy surface's whole reflection.
constexpr double kEvenLight = 1.0;

using Rgb = std::array<double, 3>;

struct Region {
  double left = 0, right = 0, top = 0, bottom = 0;  // texels
};

// Sums over regions of the map, of each colour, of what the cells share and of the solid angle: an even map's light in a region is
// its radiance times that to the last digits.
class MapSums {
 public:
  explicit MapSums(const Image& equirect);

  double importance(const Region& r) const { return over(r, 3); }
  Rgb flux(const Region& r) const { return {over(r, 0), over(r, 1), over(r, 2)}; }
  double solid_angle_sr(const Region& r) const { return over(r, 4); }
  Extent extent() const { return extent_; }

 private:
  using Sums = std::array<double, 5>;

  const Sums& corner(int x, int y) const {
    return sums_[std::size_t(y) * std::size_t(extent_.width + 1) + std::size_t(x)];
  }
  // Of everything above and to the left; linear within a texel.
  double before(double x, double y, std::size_t channel) const {
    const int i = std::min(int(x), extent_.width - 1), j = std::min(int(y), extent_.height - 1);
    const double u = x - i, v = y - j;
    return (1 - v) * ((1 - u) * corner(i, j)[channel] + u * corner(i + 1, j)[channel]) +
           v * ((1 - u) * corner(i, j + 1)[channel] + u * corner(i + 1, j + 1)[channel]);
  }
  double over(const Region& r, std::size_t channel) const {
    return std::max(before(r.right, r.bottom, channel) - before(r.left, r.bottom, channel) -
                        before(r.right, r.top, channel) + before(r.left, r.top, channel),
                    0.0);
  }

  Extent extent_;
  std::vector<Sums> sums_;
};

MapSums::MapSums(const Image& equirect) {
  const int step = (equirect.extent.width + kMostColumns - 1) / kMostColumns;
  extent_ = {(equirect.extent.width + step - 1) / step, (equirect.extent.height + step - 1) / step};
  const auto stride = std::size_t(extent_.width) + 1;
  sums_.resize(stride * (std::size_t(extent_.height) + 1));
  const auto halves = equirect.samples<std::uint16_t>();
  const auto row_halves = std::size_t(equirect.extent.width) * 4;
  std::vector<float> row(row_halves);
  double light = 0;
  for (int j = 0; j < equirect.extent.height; ++j) {
    float_from_half(halves.subspan(std::size_t(j) * row_halves, row_halves), row);
    const double texel_sr =
        (std::cos(pi * j / equirect.extent.height) - std::cos(pi * (j + 1) / equirect.extent.height)) * 2 *
        pi / equirect.extent.width;
    for (int i = 0; i < equirect.extent.width; ++i) {
      const float* color = &row[std::size_t(i) * 4];
      Sums& sums = sums_[std::size_t(j / step + 1) * stride + std::size_t(i / step + 1)];
      for (std::size_t c = 0; c < 3; ++c) sums[c] += color[c] * texel_sr;
      const double luminance = luminance_rec709(color[0], color[1], color[2]);
      sums[3] += luminance * texel_sr;
      sums[4] += texel_sr;
      light += luminance * texel_sr;
    }
  }
  for (std::size_t y = 1; y <= std::size_t(extent_.height); ++y) {
    const double row_sr =
        (std::cos(pi * double(y - 1) / extent_.height) - std::cos(pi * double(y) / extent_.height)) * 2 * pi;
    for (std::size_t x = 1; x < stride; ++x) {
      Sums& sums = sums_[y * stride + x];
      sums[3] += kEvenLight * light / (4 * pi) * row_sr / extent_.width;
      for (std::size_t c = 0; c < sums.size(); ++c) {
        sums[c] += sums_[(y - 1) * stride + x][c] + sums_[y * stride + x - 1][c] -
                   sums_[(y - 1) * stride + x - 1][c];
      }
    }
  }
}

// Where the part of the region before a line across one of its sides has `share` of its light.
double place_of(const MapSums& sums, const Region& region, double Region::*from, double Region::*to,
                double share) {
  const double wanted = share * sums.importance(region);
  double low = region.*from, high = region.*to;
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps; ++step) {
    Region part = region;
    part.*to = (low + high) / 2;
    (sums.importance(part) < wanted ? low : high) = part.*to;
  }
  return (low + high) / 2;
}

bool is_wide(const Region& region, Extent extent) {
  const double middle = pi * (region.top + region.bottom) / 2 / extent.height;
  return (region.right - region.left) * 2 / extent.width * std::sin(middle) >
         (region.bottom - region.top) / extent.height;
}

void cut(const MapSums& sums, const Region& region, int count, std::vector<Region>& cells) {
  if (count == 1) return cells.push_back(region);
  const bool wide = is_wide(region, sums.extent());
  const auto from = wide ? &Region::left : &Region::top, to = wide ? &Region::right : &Region::bottom;
  Region first = region, second = region;
  first.*to = second.*from = place_of(sums, region, from, to, double(count / 2) / count);
  cut(sums, first, count / 2, cells);
  cut(sums, second, count - count / 2, cells);
}

// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences".
double quasi_random(std::size_t i, double step) {
  const double x = 0.5 + double(i) * step;
  return x - std::floor(x);
}

}  // namespace

std::vector<LightDirection> light_cells(const Image& equirect, int count) {
  const MapSums sums(equirect);
  const Extent extent = sums.extent();
  const Region all{0, double(extent.width), 0, double(extent.height)};
  if (!(sums.importance(all) > 0)) return {};
  std::vector<Region> cells;
  cut(sums, all, count, cells);
  constexpr double kStep = 1 / 1.32471795724474602596;
  std::vector<LightDirection> lights;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const Region& cell = cells[k];
    const double y = place_of(sums, cell, &Region::top, &Region::bottom, quasi_random(k, kStep));
    const double x = place_of(sums, cell, &Region::left, &Region::right, quasi_random(k, kStep * kStep));
    const double theta = pi * y / extent.height, phi = 2 * pi * (x / extent.width - 0.5);
    LightDirection light;
    light.towards = {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
    light.irradiance = sums.flux(cell);
    light.solid_angle_sr = sums.solid_angle_sr(cell);
    lights.push_back(light);
  }
  return lights;
}

}  // namespace furnace
