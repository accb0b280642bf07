// View + plan + environment -> FrameBlock of one sub-frame of one tile.
#pragma once

#include "renderer/frame/frame_plan.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/residency/prepared_scene.hpp"

namespace furnace {

gpu::FrameBlock pack_frame(const FramePlan& plan, const View& view, const PreparedEnvironment& environment,
                           const Tile& tile, std::size_t subframe);

}  // namespace furnace
