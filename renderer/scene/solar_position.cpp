#include "renderer/scene/solar_position.hpp"

#include "renderer/scene/transform.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace furnace {
namespace {

constexpr int kFirstYear = 1950, kLastYear = 2050;

std::optional<int> digits(std::string_view text, std::size_t at, std::size_t count) {
  int value = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  return value;
}

// Saemundsson 1986, "Astronomical refraction" (Sky and Telescope 72): of a true elevation, at 1010 hPa and 10
// degrees Celsius. Its pole lies at -5.11 degrees, where nothing is seen any more.
double refraction_rad(double elevation_rad) {
  const double elevation_deg = elevation_rad * 180 / kPi;
  if (elevation_deg < -5) return 0;
  const double minutes = 1.02 / std::tan(radians_from_degrees(elevation_deg + 10.3 / (elevation_deg + 5.11)));
  return radians_from_degrees(std::max(0.0, minutes) / 60);
}

}  // namespace

std::optional<double> days_since_j2000(std::string_view text) {
  constexpr std::string_view kShort = "YYYY-MM-DDTHH:MMZ", kLong = "YYYY-MM-DDTHH:MM:SSZ";
  if (text.size() != kShort.size() && text.size() != kLong.size()) return std::nullopt;
  const std::string_view form = text.size() == kLong.size() ? kLong : kShort;
  for (std::size_t i = 0; i < form.size(); ++i)
    if ((form[i] == '-' || form[i] == ':' || form[i] == 'T' || form[i] == 'Z') && text[i] != form[i])
      return std::nullopt;
  const auto year = digits(text, 0, 4), month = digits(text, 5, 2), day = digits(text, 8, 2),
             hour = digits(text, 11, 2), minute = digits(text, 14, 2),
             second = form == kLong ? digits(text, 17, 2) : 0;
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(unsigned(*month)),
                                         std::chrono::day(unsigned(*day))};
  if (!date.ok() || *year < kFirstYear || *year > kLastYear || *hour > 23 || *minute > 59 || *second > 59)
    return std::nullopt;
  constexpr std::chrono::sys_days kEpoch =
      std::chrono::year(2000) / std::chrono::January / std::chrono::day(1);
  const double noons = double((std::chrono::sys_days(date) - kEpoch).count()) - 0.5;
  return noons + (*hour * 3600 + *minute * 60 + *second) / 86400.0;
}

// Michalsky 1988, "The Astronomical Almanac's algorithm for approximate solar position (1950-2050)".
SolarPosition solar_position(double n, double latitude_rad, double longitude_rad) {
  const double mean_longitude = radians_from_degrees(280.460 + 0.9856474 * n);
  const double mean_anomaly = radians_from_degrees(357.528 + 0.9856003 * n);
  const double ecliptic_longitude = mean_longitude + radians_from_degrees(1.915 * std::sin(mean_anomaly) +
                                                                          0.020 * std::sin(2 * mean_anomaly));
  const double obliquity = radians_from_degrees(23.439 - 0.0000004 * n);
  const double right_ascension =
      std::atan2(std::cos(obliquity) * std::sin(ecliptic_longitude), std::cos(ecliptic_longitude));
  const double declination = std::asin(std::sin(obliquity) * std::sin(ecliptic_longitude));

  const double day = n + 0.5 - std::floor(n + 0.5);  // part of it since midnight
  const double sidereal_hours = 6.697375 + 0.0657098242 * n + 24 * day;
  const double hour_angle = radians_from_degrees(15 * sidereal_hours) + longitude_rad - right_ascension;

  const double sin_elevation = std::sin(declination) * std::sin(latitude_rad) +
                               std::cos(declination) * std::cos(latitude_rad) * std::cos(hour_angle);
  const double true_elevation = std::asin(std::clamp(sin_elevation, -1.0, 1.0));
  const double east = -std::cos(declination) * std::sin(hour_angle);
  const double north = std::sin(declination) * std::cos(latitude_rad) -
                       std::cos(declination) * std::sin(latitude_rad) * std::cos(hour_angle);
  const double azimuth = std::atan2(east, north);
  return {true_elevation + refraction_rad(true_elevation), azimuth < 0 ? azimuth + 2 * kPi : azimuth};
}

}  // namespace furnace
