// What of an environment's light the scene keeps from itself: directions that stand for the environment, a few in each
// sub-frame, and how each sees the scene.
#pragma once

#include <vector>

#include "renderer/ibl/light_directions.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/render_spec.hpp"

namespace furnace {

// Whether the environment's light is shadowed.
bool sky_is_shadowed(const RenderSpec& spec);

// Directions of each sub-frame of a scene of so many triangles.
int sky_views_wanted(int subframes, std::size_t triangles);

inline constexpr int kSkyMapPx = 512;  // side of each map, where no lights' maps lie beside them

struct SkyPlan {
  gpu::SkyBlock block;
  std::vector<glm::mat4> clip_from_world;  // of each view; depth is reversed
};

// `lights`: in world space, at most gpu::MOST_SKY_VIEWS for each of `subframes`; `least_alpha`: of their sums; `scene`: bounds
// of what casts shadows, not empty; the maps are layers from `first_layer` on. Pure. Threads: any.
SkyPlan plan_sky(const std::vector<LightDirection>& lights, const Bounds& scene, double least_alpha,
                 int first_layer, int side_px, int subframe, int subframes);

}  // namespace furnace
