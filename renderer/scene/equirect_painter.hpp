// What the procedural environments share: directions, solid angles and the rounding of an equirect's texels.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/image/image.hpp"
#include "renderer/scene/procedural_environment.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {

// Veltkamp's splitting (Dekker 1971, "A floating-point technique for extending the available precision"): the
// nearest double with 11 significant bits, those of a normal half float.
inline double round_to_half_precision(double value) {
  constexpr double kSplit = 0x1p42 + 1;
  const double scaled = value * kSplit;
  return scaled - (scaled - value);
}

inline constexpr Extent kEquirectExtent{1024, 512};
inline constexpr Extent kFineEquirectExtent{2048, 1024};  // where there are edges

// Directions of texel centres in the convention of ibl/baked_environment.hpp.
struct EquirectGrid {
  Extent extent;
  std::vector<double> sin_theta, cos_theta;  // rows; theta from +Y
  std::vector<double> cos_phi, sin_phi;      // columns; phi from +X towards +Z

  explicit EquirectGrid(Extent size);

  glm::dvec3 direction(int row, int column) const {
    return {sin_theta[row] * cos_phi[column], cos_theta[row], sin_theta[row] * sin_phi[column]};
  }
  // Exact solid angle of a texel of this row, steradians.
  double texel_sr(int row) const;
  double elevation_rad(int row) const { return kPi / 2 - kPi * (row + 0.5) / extent.height; }
  double elevation_deg(int row) const { return elevation_rad(row) * 180 / kPi; }
  // From the centre of a texel to its farthest corner, at most.
  double texel_radius_rad() const { return std::hypot(kPi / extent.height, 2 * kPi / extent.width) / 2; }

  // Mean of value(direction) by 16 x 16 samples: for texels that an edge crosses.
  template <class ValueOf>
  double mean_over_texel(int row, int column, ValueOf&& value) const;
};

template <class ValueOf>
double EquirectGrid::mean_over_texel(int row, int column, ValueOf&& value) const {
  constexpr int kSide = 16;
  std::array<double, kSide> cos_of_phi, sin_of_phi;
  for (int j = 0; j < kSide; ++j) {
    const double phi = 2 * kPi * ((column + (j + 0.5) / kSide) / extent.width - 0.5);
    cos_of_phi[j] = std::cos(phi);
    sin_of_phi[j] = std::sin(phi);
  }
  double sum = 0;
  for (int i = 0; i < kSide; ++i) {
    const double theta = kPi * (row + (i + 0.5) / kSide) / extent.height;
    const double sin_of_theta = std::sin(theta), cos_of_theta = std::cos(theta);
    for (int j = 0; j < kSide; ++j)
      sum += value(glm::dvec3(sin_of_theta * cos_of_phi[j], cos_of_theta, sin_of_theta * sin_of_phi[j]));
  }
  return sum / (kSide * kSide);
}

// Calls paint(row) for each row, in any order.
void paint_rows(const Painting& painting, int rows, const std::function<void(int row)>& paint);

// RGB kFloat32; paint(row, radiance) fills one row of a std::vector<glm::dvec3>.
template <class PaintRow>
Image paint_equirect(Extent extent, PaintRow&& paint, const Painting& painting = {}) {
  Image image = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  float* const samples = image.samples<float>().data();
  paint_rows(painting, extent.height, [&](int row) {
    std::vector<glm::dvec3> radiance(extent.width);
    paint(row, radiance);
    float* sample = samples + std::size_t(row) * extent.width * 3;
    for (const glm::dvec3& texel : radiance)
      for (int channel = 0; channel < 3; ++channel)
        *sample++ = float(round_to_half_precision(texel[channel]));
  });
  return image;
}

// The unit vector of a compass: azimuth 0 is +Z, pi/2 is +X (as OrbitCamera's), elevation towards +Y.
inline glm::dvec3 direction_of(double azimuth_rad, double elevation_rad) {
  return {std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
          std::cos(azimuth_rad) * std::cos(elevation_rad)};
}

}  // namespace furnace
