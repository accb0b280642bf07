// Radiance by elevation alone.
#pragma once

#include "renderer/scene/procedural_environment.hpp"

namespace furnace {

// Hermite's cubic step: 0 up to `from`, 1 beyond `to`, without a slope at both.
double smoothstep(double from, double to, double x);

// Below the first stop and above the last their radiance goes on.
glm::dvec3 gradient_radiance(const GradientEnvironment& gradient, double elevation_deg);

}  // namespace furnace
