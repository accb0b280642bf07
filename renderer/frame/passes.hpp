// The passes of a frame, in the order they run. Each sets all state it relies on.
#pragma once

#include "renderer/frame/frame_plan.hpp"
#include "renderer/frame/frame_targets.hpp"
#include "renderer/gl/program.hpp"
#include "renderer/residency/draw_list.hpp"

namespace furnace {

// What every pass of one tile shares. Threads: the context's. Owns: nothing.
struct PassContext {
  gl::Context& context;
  gl::ProgramCache& programs;
  Residency& residency;
  const FramePlan& plan;
  const FrameTargets& targets;
  const GpuScene& scene;
  Tile tile;
  const gl::VertexArray& empty_vertex_array;
  float sky_lod;  // FrameBlock::sky_lod of the sub-frame
};

// Opaque and masked surfaces into a target cleared to the background's colour.
void pass_surface_opaque(const PassContext& pass);
// The environment, where nothing opaque was drawn.
void pass_background(const PassContext& pass);
// Blended surfaces over both, farthest first.
void pass_surface_blended(const PassContext& pass);
// Adds the sub-frame into the accumulated frame; the first one replaces it. A lone sub-frame is not accumulated.
void pass_accumulate(const PassContext& pass, bool first);
// Exposure, tone curve and transfer function of the accumulated (or lone) sub-frame into the film.
void pass_resolve(const PassContext& pass);

}  // namespace furnace
