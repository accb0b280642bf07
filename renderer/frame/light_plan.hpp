// Lights as the shaders take them, and how each sees the scene for its shadow.
#pragma once

#include <vector>

#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/light.hpp"

namespace furnace {

struct LightPlan {
  gpu::LightBlock block;
  int views = 0;    // shadow maps in use
  int side_px = 1;  // of each
};

// `scene`: bounds of what casts shadows, world; when empty nothing casts one. `tile_px`: upper left of the tile. Views are given in the order of the lights, as
// long as there are some. In one of several sub-frames each light shines from one place of its disc or sphere, so that their
// mean converges to its true shadow; a lone sub-frame has filtered ones. At most gpu::MOST_LIGHTS lights. Pure. Threads: any.
LightPlan plan_lights(const std::vector<Light>& lights, const Bounds& scene, glm::vec2 tile_px, int subframe,
                      int subframes);

}  // namespace furnace
