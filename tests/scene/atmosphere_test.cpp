#include "renderer/scene/atmosphere.hpp"

#include "renderer/image/color.hpp"
#include "renderer/scene/transform.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace furnace {
namespace {

double luminance(const glm::dvec3& color) {
  return luminance_rec709(color.r, color.g, color.b);
}

// Midpoints of 48 x 48 parts of half the sky, crowded at the horizon.
double sky_illuminance_lux(const Atmosphere& atmosphere, double sun_elevation_rad) {
  constexpr int kSteps = 48;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps, elevation = kPi / 2 * x * x;
    const double part = kPi * x / kSteps * std::cos(elevation) * std::sin(elevation);
    const Atmosphere::Ring ring = atmosphere.ring(elevation);
    for (int j = 0; j < kSteps; ++j) {
      const double azimuth = kPi * (j + 0.5) / kSteps;
      const double cos_angle = std::sin(elevation) * std::sin(sun_elevation_rad) +
                               std::cos(elevation) * std::cos(sun_elevation_rad) * std::cos(azimuth);
      sum += part * 2 * kPi / kSteps * luminance(Atmosphere::luminance(ring, azimuth, cos_angle));
    }
  }
  return sum;
}

double global_illuminance_lux(double turbidity, double sun_elevation_deg, double ground_albedo = 0.2) {
  const double sun = radians_from_degrees(sun_elevation_deg);
  const Atmosphere atmosphere(turbidity, ground_albedo, sun);
  return sky_illuminance_lux(atmosphere, sun) +
         std::max(0.0, std::sin(sun)) * luminance(atmosphere.sun_illuminance(sun));
}

// Janiczek and DeYoung 1987, "Computer programs for sun and moon illuminance with contingent tables and
// diagrams" (U.S. Naval Observatory circular 171): horizontal lux of sun and sky, fitted to measurements.
double measured_lux(double sun_elevation_deg) {
  const double x = sun_elevation_deg / 90;
  const auto fit = [x](double a, double b, double c, double d) {
    return std::pow(10, a + x * (b + x * (c + x * d)));
  };
  if (sun_elevation_deg >= 20) return fit(3.74, 3.97, -4.07, 1.47);
  if (sun_elevation_deg >= 5) return fit(3.05, 13.28, -45.98, 64.33);
  if (sun_elevation_deg >= -0.8) return fit(2.88, 22.26, -207.64, 1034.30);
  if (sun_elevation_deg >= -5) return fit(2.88, 21.81, -258.11, -858.36);
  return fit(2.70, 12.17, -431.69, -1899.83);
}

// The fit does not say how clear the air was: a fifth by day, the half in twilight, where lux fall by two
// thirds each degree.
TEST(Atmosphere, GivesTheLuxThatAreMeasured) {
  for (const double elevation : {90.0, 45.0, 20.0, 5.0})
    EXPECT_NEAR(global_illuminance_lux(3, elevation) / measured_lux(elevation), 1, 0.2) << elevation;
  for (const double elevation : {0.0, -3.0, -6.0}) {
    const double ratio = global_illuminance_lux(3, elevation) / measured_lux(elevation);
    EXPECT_LT(ratio, 1.5) << elevation;
    EXPECT_GT(ratio, 1 / 1.5) << elevation;
  }
}

// IES 1984, "Recommended practice for the calculation of daylight availability", clear sky: normal illuminance
// of the sun. A tenth, since that sky has no stated turbidity.
TEST(Atmosphere, SunIsAsBrightAsDaylightEngineersReckon) {
  const Atmosphere atmosphere(2.2, 0.2, 1);
  for (const double elevation_deg : {90.0, 60.0, 40.0, 20.0}) {
    const double elevation = radians_from_degrees(elevation_deg);
    const double reckoned = 127'500 * std::exp(-0.21 / std::sin(elevation));
    EXPECT_NEAR(luminance(atmosphere.sun_illuminance(elevation)) / reckoned, 1, 0.1) << elevation_deg;
  }
}

TEST(Atmosphere, NeverGivesMoreThanComesIn) {
  constexpr double kSolarConstantLux = 133'334;
  for (const double turbidity : {2.0, 10.0})
    for (const double elevation_deg : {20.0, 90.0})
      EXPECT_LT(global_illuminance_lux(turbidity, elevation_deg, 0),
                kSolarConstantLux * std::sin(radians_from_degrees(elevation_deg)));
}

TEST(Atmosphere, BrightGroundBrightensTheSky) {
  const double dark = global_illuminance_lux(3, 45, 0), snow = global_illuminance_lux(3, 45, 0.9);
  EXPECT_GT(snow, 1.03 * dark);
  EXPECT_LT(snow, 1.2 * dark);
}

TEST(Atmosphere, LowSunIsOrangeAndHighSunNearlyWhite) {
  const Atmosphere atmosphere(2.5, 0.2, 0);
  const glm::dvec3 low = atmosphere.sun_illuminance(radians_from_degrees(5)),
                   high = atmosphere.sun_illuminance(kPi / 2);
  EXPECT_GT(low.r, 2 * low.g);
  EXPECT_GT(low.g, 3 * low.b);
  EXPECT_LT(high.r, 1.3 * high.g);
  EXPECT_LT(high.g, 1.4 * high.b);
  EXPECT_EQ(atmosphere.sun_illuminance(-0.001), glm::dvec3(0));
}

TEST(Atmosphere, ZenithIsBlueByDayAndDeepBlueInTwilight) {
  const auto zenith = [](double sun_elevation_deg) {
    const double sun = radians_from_degrees(sun_elevation_deg);
    return Atmosphere::luminance(Atmosphere(2.5, 0.2, sun).ring(kPi / 2), 0, std::sin(sun));
  };
  const glm::dvec3 day = zenith(30), twilight = zenith(-6);
  EXPECT_GT(day.b, 1.5 * day.g);
  EXPECT_GT(day.g, 1.2 * day.r);
  // Hulburt 1953, "Explanation of the brightness and color of the sky, particularly the twilight sky": ozone.
  EXPECT_GT(twilight.b / twilight.r, 1.3 * day.b / day.r);
}

}  // namespace
}  // namespace furnace
