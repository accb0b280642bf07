// The light of a cloudless sky, worked out from what air, haze and ozone do to sunlight.
#pragma once

#include <array>
#include <vector>

#include <glm/glm.hpp>

namespace furnace {

// Linear Rec.709, in lux or cd/m2; what lies outside the gamut is negative.
//
// Threads: immutable. Owns: a map of scattered light.
class Atmosphere {
 public:
  // Turbidity is that of Preetham 1999; the sun may stand below the horizon.
  Atmosphere(double turbidity, double ground_albedo, double sun_elevation_rad);

  // What reaches the ground from the sun through the air at this elevation, on a surface that faces it. Nothing
  // from below the horizon.
  glm::dvec3 sun_illuminance(double elevation_rad) const;

  // What is scattered towards the ground along one elevation, at equal steps of azimuth from the sun's, 0 to pi.
  // Apart from the phase functions, whose peaks are too narrow for steps.
  struct Scattered {
    glm::dvec3 air, haze, many_times;
  };
  using Ring = std::vector<Scattered>;
  Ring ring(double elevation_rad) const;

  // Luminance; azimuth from the sun's, 0 to pi.
  static glm::dvec3 luminance(const Ring& ring, double azimuth_rad, double cos_sun_angle);

 private:
  // What light meets on its way, by kind, in units of a vertical path from the ground to space.
  struct Columns {
    double air = 0, haze = 0, ozone = 0;
  };
  struct Densities {
    double air, haze, ozone;  // 1/km, each with the integral 1 over height
  };
  static constexpr int kWavelengths = 16;
  using Spectrum = std::array<double, kWavelengths>;

  static Densities densities(double height_km);
  static Columns integrate_upwards(double radius_km, double mu);
  void tabulate_columns();
  Columns columns_upwards(double radius_km, double mu) const;
  Spectrum beam(double radius_km, double mu) const;
  Spectrum sunlight(double radius_km, double mu) const;
  void tabulate_many_times(double ground_albedo);
  Spectrum many_times(double height_km, double zenith_angle_rad) const;
  Spectrum second_order_gain(double height_km, double sun_zenith_angle_rad, double ground_albedo) const;
  Scattered march(double elevation_rad, double azimuth_rad) const;
  glm::dvec3 color(const Spectrum& spectrum) const;

  Spectrum air_depth_, haze_depth_, ozone_depth_;             // vertical optical depths
  std::array<glm::dvec3, kWavelengths> color_of_wavelength_;  // of the sun outside of the atmosphere, lux
  double sun_elevation_rad_;
  std::vector<Columns> columns_;      // logarithms of air and haze; by height, then by slope
  std::vector<Spectrum> many_times_;  // logarithms; by height, then by zenith angle of the sun
  std::vector<Ring> rings_;
};

}  // namespace furnace
