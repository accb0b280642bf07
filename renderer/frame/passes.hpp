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

// The environment's own texture, where every shader that reads it expects it.
void bind_sky(const PassContext& pass);

// Opaque and masked surfaces into a target cleared to the background's colour.
void pass_surface_opaque(const PassContext& pass);
// Blended surfaces over them, farthest first.
void pass_surface_blended(const PassContext& pass);
// Composes the sub-frame over the environment behind it and adds it into the accumulated frame; the first one replaces it. A lone sub-frame is not accumulated.
void pass_accumulate(const PassContext& pass, bool first);
// Exposure, tone curve and transfer function of the accumulated frame (or of the lone sub-frame, composed) into the film.
void pass_resolve(const PassContext& pass);

}  // namespace furnace
