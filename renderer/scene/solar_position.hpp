// Where the sun stands.
#pragma once

#include <optional>
#include <string_view>

namespace furnace {

// "YYYY-MM-DDTHH:MM[:SS]Z" (ISO 8601, UTC) as days since 2000-01-01 12:00; none for other texts, dates that no
// calendar has and years outside of 1950 to 2050, for which the position is good.
std::optional<double> days_since_j2000(std::string_view iso_8601_utc);

struct SolarPosition {
  double elevation_rad;  // as seen: refraction by the standard atmosphere included
  double azimuth_rad;    // from north towards east, 0 to 2 pi
};

// Latitude north, longitude east. Within 0.02 degrees.
SolarPosition solar_position(double days_since_j2000, double latitude_rad, double longitude_rad);

}  // namespace furnace
