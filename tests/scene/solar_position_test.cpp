#include "renderer/scene/solar_position.hpp"

#include "renderer/scene/transform.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace furnace {
namespace {

double degrees(double angle_rad) {
  return angle_rad * 180 / kPi;
}

SolarPosition position(const char* time, double latitude_deg, double longitude_deg) {
  return solar_position(days_since_j2000(time).value(), radians_from_degrees(latitude_deg),
                        radians_from_degrees(longitude_deg));
}

// Of the sun in the meridian, wherever that is at this time.
double noon_altitude_deg(const char* time, double latitude_deg) {
  double highest = -90;
  for (double longitude = -180; longitude < 180; longitude += 0.25)
    highest = std::max(highest, degrees(position(time, latitude_deg, longitude).elevation_rad));
  return highest;
}

TEST(DaysSinceJ2000, CountsFromNoon) {
  EXPECT_EQ(days_since_j2000("2000-01-01T12:00:00Z"), 0);
  EXPECT_EQ(days_since_j2000("2000-01-01T12:00Z"), 0);
  EXPECT_EQ(days_since_j2000("1999-12-31T00:00Z"), -1.5);
  // Meeus 1998, "Astronomical algorithms", chapter 7: 1957 October 4.81 is JD 2436116.31.
  EXPECT_NEAR(*days_since_j2000("1957-10-04T19:26:24Z"), 2436116.31 - 2451545.0, 1e-9);
  EXPECT_EQ(*days_since_j2000("2024-03-01T00:00Z") - *days_since_j2000("2024-02-28T00:00Z"), 2);
}

TEST(DaysSinceJ2000, RefusesWhatIsNoTime) {
  for (const char* text :
       {"", "2026-06-21", "2026-06-21T12:00", "2026-06-21T12:00:00", "2026-06-21T12:00:00+00:00",
        "2026-06-21 12:00:00Z", "2026-13-01T12:00Z", "2026-02-29T12:00Z", "2026-06-21T24:00Z",
        "2026-06-21T12:60Z", "2026-06-21T12:00:60Z", "1949-12-31T12:00Z", "2051-01-01T12:00Z",
        "2026-06-2xT12:00Z", "2026-06-21T12:00:00.0Z", "-026-06-21T12:00Z", "2026-06-21T12:00z"})
    EXPECT_FALSE(days_since_j2000(text)) << text;
}

// Reda and Andreas 2004, "Solar position algorithm for solar radiation applications", table A5.1: a zenith
// angle of 50.11162 degrees, an azimuth of 194.34024. The place lies 1830 m high, where the air refracts less:
// 0.005 degrees of the difference.
TEST(SolarPosition, IsThatOfThePublishedExample) {
  const SolarPosition sun = position("2003-10-17T19:30:30Z", 39.742476, -105.1786);
  EXPECT_NEAR(degrees(sun.elevation_rad), 90 - 50.11162, 0.01);
  EXPECT_NEAR(degrees(sun.azimuth_rad), 194.34024, 0.01);
}

// At the instants of the Astronomical Almanac for 2026. At noon the altitude is 90 degrees less the latitude
// plus the declination, which is 0 at an equinox and the obliquity, 23.436, at a solstice; refraction there is
// under 0.03.
TEST(SolarPosition, NoonAltitudesAtEquinoxAndSolstice) {
  for (const double latitude : {-60.0, -20.0, 0.0, 40.0, 65.0})
    EXPECT_NEAR(noon_altitude_deg("2026-03-20T14:46Z", latitude), 90 - std::abs(latitude), 0.13) << latitude;
  EXPECT_NEAR(noon_altitude_deg("2026-06-21T08:25Z", 50), 90 - 50 + 23.436, 0.03);
  EXPECT_NEAR(noon_altitude_deg("2026-12-21T20:50Z", 50), 90 - 50 - 23.436, 0.07);
  EXPECT_NEAR(noon_altitude_deg("2026-12-21T20:50Z", -50), 90 - 50 + 23.436, 0.03);
}

// Equation of time: sundials are 16 min 26 s fast at the beginning of November, 14 min 14 s slow in the middle of
// February; 2 s are 0.01 degrees.
TEST(SolarPosition, NoonIsWhereSundialsSay) {
  EXPECT_NEAR(degrees(position("2026-11-03T11:43:34Z", 51.4779, 0).azimuth_rad), 180, 0.03);
  EXPECT_NEAR(degrees(position("2026-02-11T12:14:14Z", 51.4779, 0).azimuth_rad), 180, 0.03);
  EXPECT_NEAR(degrees(position("2026-11-03T05:43:34Z", 51.4779, 90).azimuth_rad), 180, 0.05);
}

TEST(SolarPosition, RisesInTheEast) {
  const SolarPosition morning = position("2026-03-20T06:30Z", 0, 0),
                      evening = position("2026-03-20T17:30Z", 0, 0);
  EXPECT_NEAR(degrees(morning.azimuth_rad), 90, 0.5);
  EXPECT_NEAR(degrees(evening.azimuth_rad), 270, 0.5);
  EXPECT_GT(morning.elevation_rad, 0);
}

// Bennett 1982, "The calculation of astronomical refraction in marine navigation": 29' at a true altitude of 0,
// which the sun has at both poles at an equinox.
TEST(SolarPosition, IsLiftedByTheAir) {
  for (const double latitude : {-90.0, 90.0})
    EXPECT_NEAR(degrees(position("2026-03-20T14:46Z", latitude, 0).elevation_rad), 29.0 / 60, 0.02);
}

}  // namespace
}  // namespace furnace
