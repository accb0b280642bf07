#include "renderer/scene/sky.hpp"

#include "renderer/scene/equirect_painter.hpp"
#include "renderer/scene/transform.hpp"
#include "renderer/image/color.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace furnace {
namespace {

constexpr double kGroundAlbedo = 0.2;

// --- Overcast
// -------------------------------------------------------------------------------------------------------

// CIE S 011/E:2003, "Spatial distribution of daylight - CIE standard general sky", sky 16, the traditional
// overcast sky of Moon and Spencer 1942: luminance relative to the zenith.
double overcast_sky(double sin_elevation) {
  return (1 + 2 * sin_elevation) / 3;
}

// Its horizontal irradiance over pi, in units of the zenith's radiance: integrate the above times the sine.
constexpr double kOvercastIrradiance = 7.0 / 9;

// --- Clear
// ----------------------------------------------------------------------------------------------------------

constexpr double kTurbidity = 2.2;  // clean, dry air
constexpr double kSunElevation = radians_from_degrees(45);
constexpr double kSunAzimuth =
    radians_from_degrees(-20);  // left of the default camera, in front of the model
constexpr double kSunRadius = radians_from_degrees(0.2666);  // mean angular radius seen from the earth

// Perez, Seals, Michalsky 1993, "All-weather model for sky luminance distribution - preliminary configuration
// and validation", equation 1.
struct PerezLobe {
  double a, b, c, d, e;

  double gradation(double cos_zenith_angle) const { return 1 + a * std::exp(b / cos_zenith_angle); }
  double indicatrix(double sun_angle_rad, double cos_sun_angle) const {
    return 1 + c * std::exp(d * sun_angle_rad) + e * cos_sun_angle * cos_sun_angle;
  }
};

// Preetham, Shirley, Smits 1999, "A practical analytic model for daylight", appendix A.2: luminance (kcd/m2)
// and chromaticity of a clear sky.
class PreethamSky {
 public:
  PreethamSky() {
    constexpr double T = kTurbidity, s = kPi / 2 - kSunElevation;
    const std::array<PerezLobe, 3> lobes = {
        PerezLobe{0.1787 * T - 1.4630, -0.3554 * T + 0.4275, -0.0227 * T + 5.3251, 0.1206 * T - 2.5771,
                  -0.0670 * T + 0.3703},
        PerezLobe{-0.0193 * T - 0.2592, -0.0665 * T + 0.0008, -0.0004 * T + 0.2125, -0.0641 * T - 0.8989,
                  -0.0033 * T + 0.0452},
        PerezLobe{-0.0167 * T - 0.2608, -0.0950 * T + 0.0092, -0.0079 * T + 0.2102, -0.0441 * T - 1.6537,
                  -0.0109 * T + 0.0529}};
    const double chi = (4.0 / 9 - T / 120) * (kPi - 2 * s);
    const std::array<double, 3> zenith = {(4.0453 * T - 4.9710) * std::tan(chi) - 0.2155 * T + 2.4192,
                                          T * T * (((0.00166 * s - 0.00375) * s + 0.00209) * s) +
                                              T * (((-0.02903 * s + 0.06377) * s - 0.03202) * s + 0.00394) +
                                              (((0.11693 * s - 0.21196) * s + 0.06052) * s + 0.25886),
                                          T * T * (((0.00275 * s - 0.00610) * s + 0.00317) * s) +
                                              T * (((-0.04214 * s + 0.08970) * s - 0.04153) * s + 0.00516) +
                                              (((0.15346 * s - 0.26756) * s + 0.06670) * s + 0.26688)};
    for (int i = 0; i < 3; ++i) {
      lobes_[i] = lobes[i];
      zenith_[i] = zenith[i] / (lobes[i].gradation(1) * lobes[i].indicatrix(s, std::cos(s)));
    }
  }

  // What the directions of one elevation share.
  glm::dvec3 gradation(double sin_elevation) const {
    glm::dvec3 v;
    for (int i = 0; i < 3; ++i) v[i] = zenith_[i] * lobes_[i].gradation(sin_elevation);
    return v;
  }

  // Linear Rec.709 with luminance in kcd/m2; what lies outside the gamut is clipped.
  glm::dvec3 radiance(const glm::dvec3& gradation, double cos_sun_angle) const {
    const double sun_angle = std::acos(std::clamp(cos_sun_angle, -1.0, 1.0));
    glm::dvec3 v;
    for (int i = 0; i < 3; ++i) v[i] = gradation[i] * lobes_[i].indicatrix(sun_angle, cos_sun_angle);
    const double Y = v[0], x = v[1], y = v[2];
    const double X = x / y * Y, Z = (1 - x - y) / y * Y;
    // IEC 61966-2-1:1999.
    return glm::max(glm::dvec3(0),
                    glm::dvec3(3.2406 * X - 1.5372 * Y - 0.4986 * Z, -0.9689 * X + 1.8758 * Y + 0.0415 * Z,
                               0.0557 * X - 0.2040 * Y + 1.0570 * Z));
  }

 private:
  std::array<PerezLobe, 3> lobes_;
  std::array<double, 3> zenith_;
};

// Normal illuminance of the sun in klx: IES 1984, "Recommended practice for the calculation of daylight
// availability", clear sky. Its colour: extinction by air and haze at 615, 535 and 465 nm after Preetham
// 1999, appendix A.1.
glm::dvec3 sun_irradiance() {
  const double air_mass = 1 / std::sin(kSunElevation);
  const double illuminance = 127.5 * std::exp(-0.21 * air_mass);
  const double haze = 0.04608 * kTurbidity - 0.04586;
  glm::dvec3 color;
  for (int i = 0; i < 3; ++i) {
    const double wavelength_um = std::array{0.615, 0.535, 0.465}[i];
    color[i] = std::exp(-air_mass *
                        (0.008735 * std::pow(wavelength_um, -4.08) + haze * std::pow(wavelength_um, -1.3)));
  }
  return illuminance / luminance_rec709(color.r, color.g, color.b) * color;
}

// Part of a texel that the sun's disc covers, by 16 x 16 samples.
double sun_coverage(const EquirectGrid& grid, int row, int column, const glm::dvec3& sun) {
  constexpr int kSide = 16;
  const double cos_radius = std::cos(kSunRadius);
  int covered = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double theta = kPi * (row + (i / kSide + 0.5) / kSide) / grid.extent.height;
    const double phi = 2 * kPi * ((column + (i % kSide + 0.5) / kSide) / grid.extent.width - 0.5);
    const glm::dvec3 direction(std::sin(theta) * std::cos(phi), std::cos(theta),
                               std::sin(theta) * std::sin(phi));
    covered += glm::dot(direction, sun) > cos_radius;
  }
  return covered / double(kSide * kSide);
}

using Row = std::vector<glm::dvec3>;

std::vector<Row> clear_dome(const EquirectGrid& grid) {
  const PreethamSky sky;
  const glm::dvec3 sun = direction_of(kSunAzimuth, kSunElevation);
  std::vector<Row> dome(grid.extent.height / 2, Row(grid.extent.width));
  for (std::size_t row = 0; row < dome.size(); ++row) {
    const glm::dvec3 gradation = sky.gradation(grid.cos_theta[row]);
    for (int column = 0; column < grid.extent.width; ++column)
      dome[row][column] = sky.radiance(gradation, glm::dot(grid.direction(row, column), sun));
  }
  return dome;
}

// Shares the sun's irradiance out among the texels that its disc covers; none is lost, whatever the
// resolution.
void add_sun(const EquirectGrid& grid, std::vector<Row>& dome) {
  struct Texel {
    int row, column;
    double coverage;
  };
  const glm::dvec3 sun = direction_of(kSunAzimuth, kSunElevation);
  // Nearer than the disc's radius and a texel's diagonal.
  const double cos_reach = std::cos(kSunRadius + 3 * kPi / grid.extent.height);
  std::vector<Texel> disc;
  double disc_sr = 0;
  for (int row = 0; row < int(dome.size()); ++row)
    for (int column = 0; column < grid.extent.width; ++column) {
      if (glm::dot(grid.direction(row, column), sun) < cos_reach) continue;
      disc.push_back({row, column, sun_coverage(grid, row, column, sun)});
      disc_sr += disc.back().coverage * grid.texel_sr(row);
    }
  for (const Texel& texel : disc)
    dome[texel.row][texel.column] += sun_irradiance() * (texel.coverage / disc_sr);
}

glm::dvec3 horizontal_irradiance(const EquirectGrid& grid, const std::vector<Row>& dome) {
  glm::dvec3 irradiance(0);
  for (std::size_t row = 0; row < dome.size(); ++row) {
    const double weight = grid.texel_sr(row) * grid.cos_theta[row];
    for (const glm::dvec3& radiance : dome[row]) irradiance += weight * radiance;
  }
  return irradiance;
}

// --- Ground
// ---------------------------------------------------------------------------------------------------------

// A Lambertian plain that fades into the horizon's haze. Koschmieder 1924, "Theorie der horizontalen
// Sichtweite": light from the ground fades as exp(-distance), air light takes its place.
glm::dvec3 ground(double sin_elevation, const glm::dvec3& plain, const glm::dvec3& horizon) {
  constexpr double kEyeHeight = 0.025;  // in units of the distance at which 1/e of an object's light is left
  const double clear = std::exp(kEyeHeight / sin_elevation);
  return glm::mix(horizon, plain, clear);
}

}  // namespace

Image make_overcast_sky() {
  const EquirectGrid grid({256, 128});
  const double zenith = 1 / kOvercastIrradiance;
  const glm::dvec3 plain(kGroundAlbedo), horizon(zenith * overcast_sky(0));
  return paint_equirect(grid.extent, [&](int row, Row& radiance) {
    const double sin_elevation = grid.cos_theta[row];
    const glm::dvec3 level = sin_elevation > 0 ? glm::dvec3(zenith * overcast_sky(sin_elevation))
                                               : ground(sin_elevation, plain, horizon);
    std::fill(radiance.begin(), radiance.end(), level);
  });
}

// Steps: the dome in physical units, the sun's disc into it, the exposure and white balance that make its
// horizontal irradiance pi in every channel (as a camera set to a white card would), then the ground under
// it.
Image make_clear_sky() {
  const EquirectGrid grid({1024, 512});
  std::vector<Row> dome = clear_dome(grid);
  add_sun(grid, dome);
  const glm::dvec3 balance = kPi / horizontal_irradiance(grid, dome);

  const int horizon_row = int(dome.size());
  return paint_equirect(grid.extent, [&](int row, Row& radiance) {
    const Row& sky = dome[std::min(row, horizon_row - 1)];
    for (int column = 0; column < grid.extent.width; ++column) {
      const glm::dvec3 light = balance * sky[column];
      radiance[column] =
          row < horizon_row ? light : ground(grid.cos_theta[row], glm::dvec3(kGroundAlbedo), light);
    }
  });
}

}  // namespace furnace
