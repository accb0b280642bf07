// The frames of a sequence, drawn one after the other.
#pragma once

#include <cstdint>
#include <functional>

#include "server/painter.hpp"

namespace furnace {

struct SequenceLimits {
  int max_frames = 360;
  std::int64_t max_px = 128ll << 20;  // of all frames together
};

// Takes each frame with the request that it is of.
using TakeFilm = std::function<void(int frame, int frames, const RenderSpec& request, Film film)>;

// `tell` hears of each frame's stages. Every scene is imported before the first is drawn, where the camera's place depends on all of them. Automatic exposure is that
// of the first frame. Errors: those of the painter; kTooLarge at /output/sequence; what `take` throws.
void draw_frames(const Painter& painter, const RenderSpec& spec, const SequenceLimits& limits,
                 const Deadline& deadline, const TellStage& tell, const TakeFilm& take);

}  // namespace furnace
