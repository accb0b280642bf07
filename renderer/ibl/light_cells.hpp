// The light of all of an environment, as a number of directions that stand for it.
#pragma once

#include <vector>

#include "renderer/ibl/light_directions.hpp"

namespace furnace {

// The sphere in `count` cells of about equal light, a direction in each; `irradiance` is that of a plane facing it, and all of
// them hold the map's flux of each colour and the sphere's solid angle. Neighbours in the list are mostly neighbours on the sphere, so that every n-th is
// spread as well as all. The same input gives the same directions. `equirect`: RGBA kFloat16 (baked_environment.hpp); the
// directions are in its frame, the irradiances in its unit. Empty for a black map. Threads: any.
std::vector<LightDirection> light_cells(const Image& equirect, int count);

}  // namespace furnace
