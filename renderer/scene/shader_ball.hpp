// The picture of an empty request: an orb with an inlaid band, tilted on a low pedestal.
#pragma once

#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

// "body" (the orb), "core" (the band in its groove), "base" (the pedestal); stands on y = 0 about the Y axis.
std::vector<Mesh> make_shader_ball();

}  // namespace furnace
