// WebM: coded frames -> a file that can be played before all of it has come, and sought in.
#pragma once

#include <span>
#include <string>

#include "renderer/image/encode.hpp"
#include "renderer/image/vp9_stream.hpp"

namespace furnace {

// Of one video track. `alpha`: as many frames as `colour`, keys at the same places, or none.
std::string webm_file(Extent extent, const AnimationTiming& timing, std::span<const Vp9Frame> color,
                      std::span<const Vp9Frame> alpha, const std::vector<TextField>& metadata);

}  // namespace furnace
