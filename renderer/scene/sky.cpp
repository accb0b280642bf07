#include "renderer/scene/sky.hpp"

#include "renderer/scene/atmosphere.hpp"
#include "renderer/scene/equirect_painter.hpp"
#include "renderer/image/color.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace furnace {
namespace {

using Row = std::vector<glm::dvec3>;

// --- Overcast
// -------------------------------------------------------------------------------------------------------

// CIE S 011/E:2003, "Spatial distribution of daylight - CIE standard general sky", sky 16, the traditional
// overcast sky of Moon and Spencer 1942: luminance relative to the zenith.
double overcast_sky(double sin_elevation) {
  return (1 + 2 * sin_elevation) / 3;
}

// Its horizontal irradiance over pi, in units of the zenith's radiance: integrate the above times the sine.
constexpr double kOvercastIrradiance = 7.0 / 9;

// --- Clear, after Preetham
// ---------------------------------------------------------------------------------------------------------

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

std::vector<Row> preetham_dome(const EquirectGrid& grid) {
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

// --- Clear, by scattering
// ---------------------------------------------------------------------------------------------------------

// A sky that an atmosphere makes, texel by texel.
class ScatteredSky {
 public:
  ScatteredSky(const EquirectGrid& grid, const Atmosphere& atmosphere, const ClearSkyEnvironment& sky)
      : grid_(grid),
        atmosphere_(atmosphere),
        sun_(direction_of(sky.sun_azimuth_rad, sky.sun_elevation_rad)),
        horizon_(atmosphere.ring(0)) {
    for (int column = 0; column < grid.extent.width; ++column) {
      const double azimuth = std::atan2(grid.cos_phi[column], grid.sin_phi[column]);
      azimuth_from_sun_.push_back(std::abs(std::remainder(azimuth - sky.sun_azimuth_rad, 2 * kPi)));
    }
  }

  // Luminance; below the horizon that of the haze in front of the ground.
  void paint(int row, Row& luminance) const {
    const double elevation_rad = grid_.elevation_rad(row);
    const Atmosphere::Ring ring = elevation_rad > 0 ? atmosphere_.ring(elevation_rad) : horizon_;
    for (int column = 0; column < grid_.extent.width; ++column)
      luminance[column] =
          glm::max(glm::dvec3(0), Atmosphere::luminance(ring, azimuth_from_sun_[column],
                                                        glm::dot(grid_.direction(row, column), sun_)));
  }

 private:
  const EquirectGrid& grid_;
  const Atmosphere& atmosphere_;
  glm::dvec3 sun_;
  Atmosphere::Ring horizon_;
  std::vector<double> azimuth_from_sun_;
};

// White of daylight film: CIE illuminant D55, x = 0.33242, y = 0.34743 (CIE 15:2004), in linear Rec.709.
constexpr glm::dvec3 kDaylight(1.1041, 0.9869, 0.8232);

// --- The sun
// ---------------------------------------------------------------------------------------------------------

struct Disc {
  glm::dvec3 direction;
  double radius_rad;
};

// Shares the sun's irradiance out among the texels that its disc covers; none is lost, whatever the
// resolution, but what stands below the horizon. irradiance(elevation) is that of the whole disc, if all of it
// stood there.
template <class Irradiance>
void add_sun(const EquirectGrid& grid, const Disc& disc, Irradiance&& irradiance, std::vector<Row>& dome) {
  struct Texel {
    int row, column;
    double coverage;
  };
  const double cos_radius = std::cos(disc.radius_rad);
  const double cos_reach = std::cos(disc.radius_rad + grid.texel_radius_rad());
  const double cos_inside = std::cos(std::max(0.0, disc.radius_rad - grid.texel_radius_rad()));
  std::vector<Texel> texels;
  double disc_sr = 0;
  for (int row = 0; row < grid.extent.height; ++row)
    for (int column = 0; column < grid.extent.width; ++column) {
      const double cos_angle = glm::dot(grid.direction(row, column), disc.direction);
      if (cos_angle < cos_reach) continue;
      const double coverage =
          cos_angle > cos_inside ? 1 : grid.mean_over_texel(row, column, [&](const glm::dvec3& direction) {
            return glm::dot(direction, disc.direction) > cos_radius ? 1.0 : 0.0;
          });
      texels.push_back({row, column, coverage});
      disc_sr += coverage * grid.texel_sr(row);
    }
  for (const Texel& texel : texels)
    if (texel.row < int(dome.size()))
      dome[texel.row][texel.column] += irradiance(grid.elevation_rad(texel.row)) * (texel.coverage / disc_sr);
}

// Gershun 1939, "The light field": the light vector, as long as the irradiance is of a card that faces the light
// less that of its back.
double luminous_flux_density(const EquirectGrid& grid, const std::vector<Row>& dome) {
  glm::dvec3 vector(0);
  for (std::size_t row = 0; row < dome.size(); ++row)
    for (int column = 0; column < grid.extent.width; ++column) {
      const glm::dvec3& radiance = dome[row][column];
      vector += grid.texel_sr(int(row)) * luminance_rec709(radiance.r, radiance.g, radiance.b) *
                grid.direction(int(row), column);
    }
  return glm::length(vector);
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
// Sichtweite": light from the ground fades as exp(-distance), air light takes its place. Eye height in units of
// the distance at which 1/e of an object's light is left.
constexpr double kHighEye = 0.025, kLowEye = 0.004;

glm::dvec3 ground(double sin_elevation, double eye_height, const glm::dvec3& plain,
                  const glm::dvec3& horizon) {
  return glm::mix(horizon, plain, std::exp(eye_height / sin_elevation));
}

}  // namespace

Image paint_overcast(const OvercastEnvironment& overcast) {
  const EquirectGrid grid({256, 128});
  const double zenith = overcast.zenith_luminance;
  const glm::dvec3 plain(overcast.ground_albedo * zenith * kOvercastIrradiance),
      horizon(zenith * overcast_sky(0));
  return paint_equirect(grid.extent, [&](int row, Row& radiance) {
    const double sin_elevation = grid.cos_theta[row];
    const glm::dvec3 level = sin_elevation > 0 ? glm::dvec3(zenith * overcast_sky(sin_elevation))
                                               : ground(sin_elevation, kHighEye, plain, horizon);
    std::fill(radiance.begin(), radiance.end(), level);
  });
}

// Steps: the dome in physical units, the sun's disc into it, white balance and exposure, then the ground under
// it.
Image paint_clear_sky(const ClearSkyEnvironment& sky, const Painting& painting) {
  const Atmosphere atmosphere(sky.turbidity, sky.ground_albedo, sky.sun_elevation_rad);
  const EquirectGrid grid(sky.sun_disc ? kFineEquirectExtent : kEquirectExtent);
  const ScatteredSky scattered(grid, atmosphere, sky);
  std::vector<Row> dome(grid.extent.height / 2, Row(grid.extent.width));
  paint_rows(painting, int(dome.size()), [&](int row) { scattered.paint(row, dome[std::size_t(row)]); });
  const Disc disc{direction_of(sky.sun_azimuth_rad, sky.sun_elevation_rad), sky.sun_radius_rad};
  const auto sun = [&](double elevation_rad) {
    return glm::max(glm::dvec3(0), atmosphere.sun_illuminance(elevation_rad));
  };
  if (sky.sun_disc) add_sun(grid, disc, sun, dome);

  glm::dvec3 gain(1);
  if (sky.calibration == SkyCalibration::kWhiteCard) {
    gain = 1.0 / kDaylight;
    for (Row& row : dome)
      for (glm::dvec3& radiance : row) radiance *= gain;
    const double exposure = kPi / luminous_flux_density(grid, dome);
    for (Row& row : dome)
      for (glm::dvec3& radiance : row) radiance *= exposure;
    gain *= exposure;
  }
  const glm::dvec3 plain = sky.ground_albedo / kPi * horizontal_irradiance(grid, dome);
  return paint_equirect(
      grid.extent,
      [&](int row, Row& radiance) {
        if (row < int(dome.size())) {
          radiance = dome[row];
          return;
        }
        scattered.paint(row, radiance);
        for (glm::dvec3& texel : radiance) texel = ground(grid.cos_theta[row], kLowEye, plain, gain * texel);
      },
      painting);
}

// Steps as there, but the white balance and exposure make the horizontal irradiance pi in every channel.
Image make_clear_sky() {
  constexpr double kGroundAlbedo = 0.2;
  const EquirectGrid grid(kEquirectExtent);
  std::vector<Row> dome = preetham_dome(grid);
  const Row haze = dome.back();
  const glm::dvec3 sun = sun_irradiance();
  add_sun(
      grid, {direction_of(kSunAzimuth, kSunElevation), kSunRadius}, [&](double) { return sun; }, dome);
  const glm::dvec3 balance = kPi / horizontal_irradiance(grid, dome);
  return paint_equirect(grid.extent, [&](int row, Row& radiance) {
    const bool above = row < int(dome.size());
    for (int column = 0; column < grid.extent.width; ++column)
      radiance[column] =
          above ? balance * dome[row][column]
                : ground(grid.cos_theta[row], kHighEye, glm::dvec3(kGroundAlbedo), balance * haze[column]);
  });
}

}  // namespace furnace
