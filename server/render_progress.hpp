// How far a picture, a sequence or a batch has come.
#pragma once

#include <functional>
#include <string_view>

namespace furnace {

struct RenderProgress {
  int frames_done = 0, frames = 0;  // of a sequence, or items of a batch; frames 0: it is neither
  std::string_view stage = {};      // bake, draw: a constant; empty: not known
  double share = 0;                 // of the stage that is done, where that is known
};

// Called on the thread that asked for the picture; may throw to end it.
using TellProgress = std::function<void(const RenderProgress&)>;

}  // namespace furnace
