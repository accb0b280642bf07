// The passes of a frame, in the order they run. Each sets all state it relies on.
#pragma once

#include <span>

#include "renderer/frame/frame_plan.hpp"
#include "renderer/frame/frame_targets.hpp"
#include "renderer/gl/program.hpp"
#include "renderer/residency/draw_list.hpp"

namespace furnace {

// What every pass of one sub-frame of one tile shares. Threads: the context's. Owns: nothing.
struct PassContext {
  gl::Context& context;
  gl::ProgramCache& programs;
  Residency& residency;
  const FramePlan& plan;
  const FrameTargets& targets;
  const GpuScene& scene;
  Tile tile;
  const gl::VertexArray& empty_vertex_array;
  const gpu::FrameBlock& frame;
  const gl::Texture* glow = nullptr;  // of the whole picture, where there is bloom
  bool is_backdrop =
      false;              // draws what stands behind transmissive surfaces: neither these nor the background
  bool emission = false;  // nothing is drawn but what surfaces emit
  // Maps of light_sums.hpp; null where surfaces see all of the environment, whatever the scene hides.
  const gl::Texture* sky_sums = nullptr;

  bool veiled() const { return !scene.blended.empty() || !scene.strokes.empty(); }
  // The features of a surface as this pass shows it.
  gl::FeatureSet shown(gl::FeatureSet surface) const {
    if (emission) return surface | gl::kFeatureEmission;
    const bool hidden_from = sky_sums != nullptr && (surface & gl::kFeatureUnlit) == 0;
    return hidden_from ? surface | gl::kFeatureEnvironmentVisibility : surface;
  }
};

enum class Casters { kExact, kSimplified };

// What each view sees of the scene, into its layer of the shadow maps.
void pass_shadow(const PassContext& pass, std::span<const glm::mat4> clip_from_world, int first_layer,
                 Casters casters);
// Opaque and masked triangles: which one each sample sees.
void pass_visibility(const PassContext& pass);
// Lines and points, then blended surfaces, farthest first, where no opaque triangle hides them.
void pass_veil(const PassContext& pass);
// Shades what is visible: once a pixel and surface.
void pass_shade(const PassContext& pass);
// Composes the sub-frame with veil and background and adds it into the accumulated frame by its weight; the first one replaces
// it. A lone sub-frame is not accumulated, but for its emission and for the backdrop.
void pass_accumulate(const PassContext& pass, std::size_t subframe);
// The accumulated tile, into its place in the backdrop.
void pass_backdrop(const PassContext& pass);
// Exposure, bloom, tone curve and transfer function of the accumulated frame (or of the lone sub-frame, composed) into the
// film; of a plan for the glow, what glows.
void pass_resolve(const PassContext& pass);

}  // namespace furnace
