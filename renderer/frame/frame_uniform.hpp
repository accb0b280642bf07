// View + plan + prepared scene -> FrameBlock of one sub-frame of one tile.
#pragma once

#include "renderer/frame/frame_plan.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/residency/residency.hpp"

namespace furnace {

// `ground_map`: the part of the ground whose shadow is known, or null.
gpu::FrameBlock pack_frame(const FramePlan& plan, const View& view, const PreparedScene& scene,
                           const GroundRectangle* ground_map, const Tile& tile, std::size_t subframe);

}  // namespace furnace
