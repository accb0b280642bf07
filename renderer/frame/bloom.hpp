// The glow round what is bright. It is made of a small picture of the whole frame, drawn before: of the same height whatever the
// picture's, so that all sizes of a picture glow alike and no tile shows in it.
#pragma once

#include "renderer/frame/frame_plan.hpp"

namespace furnace {

// What is drawn for the glow of the picture that `plan`, which has bloom, draws: what exceeds the threshold, exposed.
FramePlan plan_glow(const FramePlan& plan, int max_tile_px);

// What plan_glow() drew (RGBA kFloat32), spread; its sum stays. `picture`: the size for which it is. Pure. Threads: any.
Image spread_glow(const Image& bright, const Bloom& bloom, Extent picture);

}  // namespace furnace
