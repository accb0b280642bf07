// An environment's light on a horizontal plane, as a number of directions that stand for all of it.
#pragma once

#include <array>
#include <vector>

#include "renderer/image/image.hpp"

namespace furnace {

// Threads: a value.
struct LightDirection {
  std::array<double, 3> towards{};  // unit, y > 0, in the frame of the environment
  std::array<double, 3> weight{};   // RGB: its share of the irradiance
};

// `count` directions above the horizon, as dense as their light on the plane; in each colour that shines at all the weights
// add up to 1. The same input gives the same directions; a longer list refines a shorter one. `equirect`: RGBA kFloat16
// (baked_environment.hpp), in any unit. Empty for a map without light above the horizon.
// Threads: any.
std::vector<LightDirection> ground_light(const Image& equirect, int count);

}  // namespace furnace
