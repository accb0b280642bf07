// A picture of a film layer's numbers, to be looked at; or, for an EXR, the numbers themselves.
#pragma once

#include "renderer/frame/frame_plan.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Nearest and farthest that a scene of these bounds can be from the eye, along the viewing direction, m; never less than 0.
struct DepthRange {
  double near_m = 0, far_m = 1;
};
DepthRange depth_range(const View& view, const Bounds& scene);

// `numbers`: FilmLayers::shown(), of plan.layers.shown. Scene-linear film: Y or RGB as they are, with A before a transparent
// background. Pictures: RGB or RGBA (straight alpha) of the film's type, where
//   depths run from white at the nearest to black at the farthest of the scene's bounds, positions from black to full red,
//   green and blue within them; normals n are n / 2 + 1 / 2; uv is its fraction in red and green; numbers have stable colours;
//   motion is 1 / 2 for what stands still, and v / 64 px more in red and green;
//   albedo is a colour; D is D / (1 + D); lines are white on grey; all else is grey, 1 white.
// Nothing but albedo goes through the transfer function of sRGB.
Image view_of(const Image& numbers, const FramePlan& plan, const View& view, const Bounds& scene);

}  // namespace furnace
