// Light as a number of directions that stand for all of it; on a horizontal plane.
#pragma once

#include <array>
#include <vector>

#include "renderer/image/image.hpp"

namespace furnace {

// Threads: a value.
struct LightDirection {
  std::array<double, 3> towards{};     // unit
  std::array<double, 3> irradiance{};  // RGB: of the plane, here; else as a list says
  double solid_angle_sr = 0;           // that it stands for, where a list says
};

// `count` directions above the horizon, as dense as their light on the plane; their irradiances add up to the map's. The same
// input gives the same directions; a longer list refines a shorter one. `equirect`: RGBA kFloat16 (baked_environment.hpp); the
// directions are in its frame, the irradiances in its unit. Empty for a map without light above the horizon. Threads: any.
std::vector<LightDirection> ground_light(const Image& equirect, int count);

// The same of an even disc far away: `irradiance` is that of a plane facing `towards`. Empty below the horizon.
std::vector<LightDirection> ground_light(const std::array<double, 3>& towards,
                                         const std::array<double, 3>& irradiance, double angular_radius_rad,
                                         int count);

// About `count` directions of several sources of `count` each: of each source so many as it has of the light, its irradiance
// kept.
std::vector<LightDirection> joined_by_light(std::vector<std::vector<LightDirection>> sources, int count);

}  // namespace furnace
