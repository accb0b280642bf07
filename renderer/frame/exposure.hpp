// How much light a picture takes: the photographer's numbers and a meter as stops.
#pragma once

#include "renderer/frame/frame_plan.hpp"

namespace furnace {

// Stops by which radiance in cd/m2 is multiplied for a camera of that EV100.
double exposure_ev_of_ev100(double ev100);

// What is drawn to meter the picture of `spec`: small, scene-linear, unexposed, without backgrounds that are no light. Its
// size is the same for large and small pictures, so all sizes of one picture are exposed alike.
FramePlan plan_meter(const RenderSpec& spec, int max_tile_px);

// Stops that bring the log-average of a scene-linear premultiplied RGBA picture to mid grey, in hundredths, so that they can
// be told exactly; 0 for a picture without light. Same picture, same stops.
double metered_ev(const Image& picture);

}  // namespace furnace
