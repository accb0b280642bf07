// A pixel's filter, sampled: sub-frames lie where it is large, and only its sign, and how much there is of either, is left to
// their weights.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/render_spec.hpp"

namespace furnace {

// Along one axis, not normalised; 0 beyond the radius.
double filter_value(const PixelFilter& filter, double offset_px);

// Moves places that fill [-0.5, 0.5)^2 evenly so that they are as dense as the filter's absolute value, and gives the weight of
// each; their sum is 1. The middle stays. The box of half a pixel changes nothing.
std::vector<float> warp_by_filter(const PixelFilter& filter, std::vector<glm::vec2>& places);

}  // namespace furnace
