// Places that stand for all of a light that has a size. Any beginning of each sequence is well spread.
#pragma once

#include <glm/glm.hpp>

#include "renderer/scene/light.hpp"

namespace furnace {

// In the unit disc, evenly.
glm::dvec2 disc_place(int i);

// In the unit ball, so that from every side they fill the ball's disc evenly.
glm::dvec3 ball_place(int i);

// m, world: on a flat light, within a ball, across a spot. All the same where a light has no size. Of a light that is not
// directional.
glm::dvec3 place_on(const Light& light, int i);

// m: of a ball that holds all of the light.
double extent_m(const Light& light);

}  // namespace furnace
