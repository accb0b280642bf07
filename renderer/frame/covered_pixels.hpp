// Where in a tile something may be seen.
#pragma once

#include "renderer/gl/pass_state.hpp"
#include "renderer/residency/draw_list.hpp"

namespace furnace {

// The pixels that a draw may cover: of its bounds' corners, or all where one lies behind the eye.
gl::PixelRect covered_pixels(const gpu::FrameBlock& frame, Extent tile, const Draw& draw);

// Those that the scene's blended surfaces, lines and points may cover.
gl::PixelRect veiled_pixels(const gpu::FrameBlock& frame, Extent tile, const GpuScene& scene);

}  // namespace furnace
