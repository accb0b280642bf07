// Nishita, Sirai, Tadamura, Nakamae 1993, "Display of the earth taking into account atmospheric scattering":
// light that is scattered once, in spherical shells. Hillaire 2020, "A scalable and production ready sky and
// atmosphere rendering technique": light that is scattered more often, as if it were so evenly to all sides.
#include "renderer/scene/atmosphere.hpp"

#include "renderer/scene/gradient.hpp"
#include "renderer/scene/transform.hpp"

#include <algorithm>
#include <cmath>

namespace furnace {
namespace {

constexpr double kGround = 6371;        // km, the earth's mean radius
constexpr double kThickness = 100;      // km; above, no scattering is seen
constexpr double kAirScale = 8.0;       // km; Bruneton and Neyret 2008, "Precomputed atmospheric scattering"
constexpr double kHazeScale = 1.2;      // km; the same
constexpr double kOzoneMiddle = 25;     // km; Bruneton 2017, "A qualitative and quantitative evaluation of 8
constexpr double kOzoneReach = 15;      // clear sky models": a triangle
constexpr double kHazeAlbedo = 0.9;     // Bruneton and Neyret 2008: what haze does not swallow
constexpr double kHazeAsymmetry = 0.8;  // mean cosine; the same
constexpr double kOzoneColumn = 0.3;    // cm at normal pressure: 300 Dobson units
// Darula, Kittler, Gueymard 2005, "Reference luminous solar constant and solar luminance for illuminance
// calculations".
constexpr double kSolarConstantLux = 133'334;
constexpr double kSolarTemperature = 5772;  // K; IAU 2015, resolution B3

constexpr double kFirstWavelength = 0.39, kWavelengthStep = 0.02;  // um

double square(double x) {
  return x * x;
}

// --- Colours
// ---------------------------------------------------------------------------------------------------------

// Wyman, Sloan, Shirley 2013, "Simple analytic approximations to the CIE XYZ color matching functions", section
// 2.2: sums of Gaussians whose halves differ.
glm::dvec3 xyz_of_wavelength(double nm) {
  const auto lobe = [nm](double middle, double below, double above) {
    return std::exp(-0.5 * square((nm - middle) * (nm < middle ? below : above)));
  };
  return {1.056 * lobe(599.8, 0.0264, 0.0323) + 0.362 * lobe(442.0, 0.0624, 0.0374) -
              0.065 * lobe(501.1, 0.0490, 0.0382),
          0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
          1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725)};
}

// IEC 61966-2-1:1999.
glm::dvec3 rec709_from_xyz(const glm::dvec3& c) {
  return {3.2406 * c.x - 1.5372 * c.y - 0.4986 * c.z, -0.9689 * c.x + 1.8758 * c.y + 0.0415 * c.z,
          0.0557 * c.x - 0.2040 * c.y + 1.0570 * c.z};
}

// Planck 1901, "Ueber das Gesetz der Energieverteilung im Normalspectrum": of any scale.
double black_body(double wavelength_um, double temperature) {
  constexpr double kSecondConstant = 14387.77;  // um K
  return 1 / (std::pow(wavelength_um, 5) * std::expm1(kSecondConstant / (wavelength_um * temperature)));
}

// --- Directions
// ---------------------------------------------------------------------------------------------------------

// Rayleigh 1871, "On the light from the sky, its polarization and colour".
double air_phase(double cos_angle) {
  return 3 / (16 * kPi) * (1 + square(cos_angle));
}

// Cornette and Shanks 1992, "Physically reasonable analytic expression for the single-scattering phase
// function".
double haze_phase(double cos_angle) {
  constexpr double g = kHazeAsymmetry;
  const double narrowing = 1 + g * g - 2 * g * cos_angle;
  return 3 / (8 * kPi) * (1 - g * g) * (1 + square(cos_angle)) /
         ((2 + g * g) * narrowing * std::sqrt(narrowing));
}

// --- Tables
// ---------------------------------------------------------------------------------------------------------

// Against tables and steps two to five times as fine the sky differs by 1 % by day, up to 2 % in haze and 4 % at
// the end of twilight (RMS), under what the models of the air leave open.
constexpr int kColumnHeights = 65, kColumnSlopes = 65;
constexpr int kManyHeights = 16, kManyAngles = 13;
// Rays from the ground leave the atmosphere within 10.1 degrees of arc.
constexpr double kManyReach = radians_from_degrees(10.5);
constexpr int kRings = 48, kRingSteps = 18;

// A place between two entries of a table.
struct Between {
  int index;
  double part;
};
Between between(double place, int count) {
  const double held = std::clamp(place, 0.0, count - 1.0);
  const int index = std::min(int(held), count - 2);
  return {index, held - index};
}

// Catmull and Rom 1974, "A class of local interpolating splines".
std::array<double, 4> spline(double t) {
  return {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2 - 1.5 * t)),
          t * t * (-0.5 + 0.5 * t)};
}

double to_space_km(double radius_km, double mu) {
  const double top = kGround + kThickness;
  return std::sqrt(std::max(0.0, square(radius_km * mu) + (top - radius_km) * (top + radius_km))) -
         radius_km * mu;
}

double height_after_km(double radius_km, double mu, double distance_km) {
  return std::max(
      0.0, std::sqrt(square(radius_km) + square(distance_km) + 2 * radius_km * mu * distance_km) - kGround);
}

}  // namespace

Atmosphere::Atmosphere(double turbidity, double ground_albedo, double sun_elevation_rad)
    : sun_elevation_rad_(sun_elevation_rad) {
  // Preetham, Shirley, Smits 1999, "A practical analytic model for daylight", appendix A.1: turbidity as
  // Angstrom's coefficient of haze, and the depth of air.
  const double haze = 0.04608 * turbidity - 0.04586;
  double lux = 0;
  for (int i = 0; i < kWavelengths; ++i) {
    const double um = kFirstWavelength + i * kWavelengthStep;
    air_depth_[i] = 0.008735 * std::pow(um, -4.08);
    haze_depth_[i] = haze * std::pow(um, -1.3);
    // Leckner 1978, "The spectral distribution of solar radiation at the earth's surface - elements of a model":
    // his coefficients of the Chappuis band, 1/cm, within 0.012.
    ozone_depth_[i] = kOzoneColumn * 0.125 * std::exp(-0.5 * square((um - 0.59) / 0.05));
    const glm::dvec3 xyz = xyz_of_wavelength(1000 * um) * black_body(um, kSolarTemperature);
    lux += xyz.y;
    color_of_wavelength_[i] = rec709_from_xyz(xyz);
  }
  for (glm::dvec3& c : color_of_wavelength_) c *= kSolarConstantLux / lux;

  tabulate_columns();
  tabulate_many_times(ground_albedo);
  for (int i = 0; i < kRings; ++i) {
    const double elevation = kPi / 2 * square(i / (kRings - 1.0));
    Ring& ring = rings_.emplace_back();
    for (int j = 0; j <= kRingSteps; ++j) ring.push_back(march(elevation, kPi * j / kRingSteps));
  }
}

Atmosphere::Densities Atmosphere::densities(double height_km) {
  return {std::exp(-height_km / kAirScale) / kAirScale, std::exp(-height_km / kHazeScale) / kHazeScale,
          std::max(0.0, 1 - std::abs(height_km - kOzoneMiddle) / kOzoneReach) / kOzoneReach};
}

// --- Columns
// ---------------------------------------------------------------------------------------------------------

Atmosphere::Columns Atmosphere::integrate_upwards(double radius_km, double mu) {
  constexpr int kSteps = 48;  // crowded at the near end, where the air is densest
  const double length = to_space_km(radius_km, mu);
  Columns columns;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps;
    const double step = 3 * length * x * x / kSteps;
    const Densities density = densities(height_after_km(radius_km, mu, length * x * x * x));
    columns.air += step * density.air;
    columns.haze += step * density.haze;
    columns.ozone += step * density.ozone;
  }
  return columns;
}

void Atmosphere::tabulate_columns() {
  constexpr double kNothing = 1e-30;
  for (int i = 0; i < kColumnHeights; ++i)
    for (int j = 0; j < kColumnSlopes; ++j) {
      Columns columns = integrate_upwards(kGround + kThickness * i / (kColumnHeights - 1),
                                          square(j / (kColumnSlopes - 1.0)));
      columns.air = std::log(columns.air + kNothing);
      columns.haze = std::log(columns.haze + kNothing);
      columns_.push_back(columns);
    }
}

// `mu` is the cosine of the angle to the local zenith, not negative.
Atmosphere::Columns Atmosphere::columns_upwards(double radius_km, double mu) const {
  const Between height = between((radius_km - kGround) / kThickness * (kColumnHeights - 1), kColumnHeights);
  const Between slope = between(std::sqrt(mu) * (kColumnSlopes - 1), kColumnSlopes);
  Columns sum;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const double weight = (i ? height.part : 1 - height.part) * (j ? slope.part : 1 - slope.part);
      const Columns& entry = columns_[(height.index + i) * kColumnSlopes + slope.index + j];
      sum.air += weight * entry.air;
      sum.haze += weight * entry.haze;
      sum.ozone += weight * entry.ozone;
    }
  return {std::exp(sum.air), std::exp(sum.haze), sum.ozone};
}

// Part of the light of a point outside of the atmosphere that arrives; from below the horizon, what would graze
// the ground.
Atmosphere::Spectrum Atmosphere::beam(double radius_km, double mu) const {
  Columns columns;
  if (mu >= 0) {
    columns = columns_upwards(radius_km, mu);
  } else {
    // Down to the lowest point and up again: twice from there, less what lies behind the start.
    const double lowest = std::max(kGround, radius_km * std::sqrt(1 - mu * mu));
    const Columns whole = columns_upwards(lowest, 0), behind = columns_upwards(radius_km, -mu);
    columns = {2 * whole.air - behind.air, 2 * whole.haze - behind.haze, 2 * whole.ozone - behind.ozone};
  }
  Spectrum light;
  for (int i = 0; i < kWavelengths; ++i)
    light[i] = std::exp(
        -(columns.air * air_depth_[i] + columns.haze * haze_depth_[i] + columns.ozone * ozone_depth_[i]));
  return light;
}

// Of the sun, which goes down little by little.
Atmosphere::Spectrum Atmosphere::sunlight(double radius_km, double mu) const {
  constexpr double kSunRadius = radians_from_degrees(0.2666);  // mean angular radius seen from the earth
  const double dip = std::acos(std::min(1.0, kGround / radius_km));
  const double seen = smoothstep(-kSunRadius, kSunRadius, std::asin(std::clamp(mu, -1.0, 1.0)) + dip);
  if (seen == 0) return {};
  Spectrum light = beam(radius_km, mu);
  for (double& value : light) value *= seen;
  return light;
}

// --- Light that is scattered more than once
// ---------------------------------------------------------------------------------------------------------

// Hillaire 2020, equations 5 to 10.
Atmosphere::Spectrum Atmosphere::second_order_gain(double height_km, double sun_zenith_angle_rad,
                                                   double ground_albedo) const {
  constexpr int kZeniths = 12, kAzimuths = 4, kSteps = 16;
  const glm::dvec2 sun(std::sin(sun_zenith_angle_rad), std::cos(sun_zenith_angle_rad));
  const double radius = kGround + height_km;
  Spectrum second{}, returned{};
  for (int ray = 0; ray < kZeniths * kAzimuths; ++ray) {
    const double mu = 1 - (ray / kAzimuths + 0.5) * 2 / kZeniths;
    const double across = std::sqrt(1 - mu * mu) * std::cos((ray % kAzimuths + 0.5) * kPi / kAzimuths);
    const double below = square(radius * mu) - (radius - kGround) * (radius + kGround);
    const bool lands = mu < 0 && below >= 0;
    const double length = lands ? -radius * mu - std::sqrt(below) : to_space_km(radius, mu);
    // Cosine of the sun's zenith angle at a distance along the ray.
    const auto sun_mu = [&](double distance) {
      const double r = std::max(kGround, height_after_km(radius, mu, distance) + kGround);
      return ((radius + mu * distance) * sun.y + across * distance * sun.x) / r;
    };
    Spectrum left;
    left.fill(1);
    double begin = 0;
    for (int step = 0; step < kSteps; ++step) {
      const double x = (step + 1.0) / kSteps;
      const double end = length * (lands ? 1 - square(1 - x) : x * x);
      const double middle = (begin + end) / 2, height = height_after_km(radius, mu, middle);
      const Densities density = densities(height);
      const Spectrum light = sunlight(kGround + height, sun_mu(middle));
      for (int i = 0; i < kWavelengths; ++i) {
        const double air = density.air * air_depth_[i], haze = density.haze * haze_depth_[i];
        const double extinction = air + haze + density.ozone * ozone_depth_[i];
        const double scattered = air + kHazeAlbedo * haze;
        const double through = std::exp(-extinction * (end - begin));
        const double path = left[i] * scattered * (1 - through) / extinction;
        second[i] += path * light[i] / (4 * kPi);
        returned[i] += path;
        left[i] *= through;
      }
      begin = end;
    }
    if (!lands) continue;
    const double mu_on_ground = sun_mu(length);
    const Spectrum light = sunlight(kGround, mu_on_ground);
    for (int i = 0; i < kWavelengths; ++i)
      second[i] += left[i] * light[i] * std::max(0.0, mu_on_ground) * ground_albedo / kPi;
  }
  Spectrum gain;
  constexpr int kRays = kZeniths * kAzimuths;
  for (int i = 0; i < kWavelengths; ++i) gain[i] = second[i] / kRays / (1 - returned[i] / kRays);
  return gain;
}

void Atmosphere::tabulate_many_times(double ground_albedo) {
  constexpr double kNothing = 1e-30;
  for (int i = 0; i < kManyHeights; ++i)
    for (int j = 0; j < kManyAngles; ++j) {
      const double angle = kPi / 2 - sun_elevation_rad_ + kManyReach * (2.0 * j / (kManyAngles - 1) - 1);
      Spectrum& entry = many_times_.emplace_back(
          second_order_gain(kThickness * square(i / (kManyHeights - 1.0)), angle, ground_albedo));
      for (double& value : entry) value = std::log(value + kNothing);
    }
}

Atmosphere::Spectrum Atmosphere::many_times(double height_km, double zenith_angle_rad) const {
  const Between height = between(std::sqrt(height_km / kThickness) * (kManyHeights - 1), kManyHeights);
  const double from_sun = zenith_angle_rad - (kPi / 2 - sun_elevation_rad_);
  const Between angle = between((from_sun / kManyReach + 1) / 2 * (kManyAngles - 1), kManyAngles);
  Spectrum sum{};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const double weight = (i ? height.part : 1 - height.part) * (j ? angle.part : 1 - angle.part);
      const Spectrum& entry = many_times_[(height.index + i) * kManyAngles + angle.index + j];
      for (int k = 0; k < kWavelengths; ++k) sum[k] += weight * entry[k];
    }
  for (double& value : sum) value = std::exp(value);
  return sum;
}

// --- The sky
// ---------------------------------------------------------------------------------------------------------

Atmosphere::Scattered Atmosphere::march(double elevation_rad, double azimuth_rad) const {
  constexpr int kSteps = 64;
  const double mu = std::sin(elevation_rad), length = to_space_km(kGround, mu);
  const double across = std::cos(elevation_rad) * std::cos(azimuth_rad);
  const glm::dvec2 sun(std::cos(sun_elevation_rad_), std::sin(sun_elevation_rad_));
  Spectrum air_sum{}, haze_sum{}, many_sum{}, left;
  left.fill(1);
  double begin = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double x = (step + 1.0) / kSteps;
    const double end = length * x * x * x;
    const double middle = (begin + end) / 2, height = height_after_km(kGround, mu, middle);
    const Densities density = densities(height);
    const double sun_mu = ((kGround + mu * middle) * sun.y + across * middle * sun.x) / (kGround + height);
    const Spectrum light = sunlight(kGround + height, sun_mu);
    const Spectrum many = many_times(height, std::acos(std::clamp(sun_mu, -1.0, 1.0)));
    for (int i = 0; i < kWavelengths; ++i) {
      const double air = density.air * air_depth_[i], haze = density.haze * haze_depth_[i];
      const double extinction = air + haze + density.ozone * ozone_depth_[i];
      const double through = std::exp(-extinction * (end - begin));
      const double path = left[i] * (1 - through) / extinction;
      air_sum[i] += path * air * light[i];
      haze_sum[i] += path * kHazeAlbedo * haze * light[i];
      many_sum[i] += path * (air + kHazeAlbedo * haze) * many[i];
      left[i] *= through;
    }
    begin = end;
  }
  return {color(air_sum), color(haze_sum), color(many_sum)};
}

glm::dvec3 Atmosphere::color(const Spectrum& spectrum) const {
  glm::dvec3 sum(0);
  for (int i = 0; i < kWavelengths; ++i) sum += spectrum[i] * color_of_wavelength_[i];
  return sum;
}

glm::dvec3 Atmosphere::sun_illuminance(double elevation_rad) const {
  return elevation_rad < 0 ? glm::dvec3(0) : color(beam(kGround, std::sin(elevation_rad)));
}

Atmosphere::Ring Atmosphere::ring(double elevation_rad) const {
  const Between place = between(std::sqrt(std::max(0.0, elevation_rad) / (kPi / 2)) * (kRings - 1), kRings);
  const auto weights = spline(place.part);
  Ring sum(kRingSteps + 1);
  for (int i = 0; i < 4; ++i) {
    const Ring& entry = rings_[std::clamp(place.index + i - 1, 0, kRings - 1)];
    for (int j = 0; j <= kRingSteps; ++j) {
      sum[j].air += weights[i] * entry[j].air;
      sum[j].haze += weights[i] * entry[j].haze;
      sum[j].many_times += weights[i] * entry[j].many_times;
    }
  }
  return sum;
}

glm::dvec3 Atmosphere::luminance(const Ring& ring, double azimuth_rad, double cos_sun_angle) {
  const Between place = between(azimuth_rad / kPi * kRingSteps, kRingSteps + 1);
  const auto weights = spline(place.part);
  const double air = air_phase(cos_sun_angle), haze = haze_phase(cos_sun_angle);
  glm::dvec3 sum(0);
  for (int i = 0; i < 4; ++i) {
    // The two halves of the sky are mirror images.
    const int j = std::abs(place.index + i - 1);
    const Scattered& entry = ring[j > kRingSteps ? 2 * kRingSteps - j : j];
    sum += weights[i] * (air * entry.air + haze * entry.haze + entry.many_times);
  }
  return sum;
}

}  // namespace furnace
