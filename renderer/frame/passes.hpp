// The passes of a frame, in the order they run. Each sets all state it relies on.
#pragma once

#include <span>

#include "renderer/frame/frame_plan.hpp"
#include "renderer/frame/frame_targets.hpp"
#include "renderer/gl/pass_state.hpp"
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
  std::optional<FilmLayer> shown = {};  // in place of radiance: one of LayerPlan::sources
  const ColorTarget* sum =
      nullptr;  // where sub-frames are added up; null: a lone one is resolved as it was shaded
  // Maps of light_sums.hpp; null where surfaces see all of the environment, whatever the scene hides.
  const gl::Texture* sky_sums = nullptr;
  // Where those of negative weight are added up apart; null: in `sum`, as what they are.
  const ColorTarget* lobes = nullptr;
  bool alone = false;              // this sub-frame is all that comes into `sum`
  gl::PixelRect veil = {};         // the pixels that it may cover
  bool first_is_selected = false;  // nothing was shaded since pass_visibility()

  bool shows(FilmLayerKind kind) const { return shown && row_of(*shown).kind == kind; }
  bool draws(const Draw& draw) const { return !is_backdrop || !draw.seen_through(); }
  bool veiled() const { return !veil.empty() && !shows(FilmLayerKind::kPlace); }
  // Numbers of surfaces are no radiance; the veil holds them as they are.
  float veil_exposure() const { return shows(FilmLayerKind::kValue) ? 1 : float(plan.exposure); }
};

enum class Casters { kExact, kSimplified };

// What each view sees of the scene, into its layer of the shadow maps.
void pass_shadow(const PassContext& pass, std::span<const glm::mat4> clip_from_world, int first_layer,
                 Casters casters);
// What a pixel shows: a part of each surface that its samples see, or all of the nearest one.
enum class VisibleSurfaces { kAll, kNearest };

// Opaque and masked triangles: which one each sample sees, and which samples of a pixel take one shading.
void pass_visibility(const PassContext& pass, VisibleSurfaces surfaces);
// Equal where pass_visibility(pass, kAll) would find the same; nullopt: not known (textures mask triangles; lines or points
// will leave their depth).
std::optional<ContentHash> visibility_key(const PassContext& pass, const PreparedScene& prepared);
// Lines and points, then blended surfaces, farthest first, where no opaque triangle hides them.
void pass_veil(const PassContext& pass);
// Shades what is visible: once a pixel and surface.
void pass_shade(const PassContext& pass);
// Composes the sub-frame with veil and background and adds it into `sum` by its weight; the first one replaces what was there.
void pass_accumulate(const PassContext& pass, std::size_t subframe);
// The two sums of the picture, of either sign, as one into `sum`, so that no pixel is blacker beside a sun than beside white.
void pass_limit_lobes(const PassContext& pass);
// What was shaded, as it is, into `sum`.
void pass_keep(const PassContext& pass);
// What bloom adds to the picture and takes from it, of all sub-frames, into a target.
void pass_glow(const PassContext& pass, const ColorTarget& into);
// The accumulated tile, into its place in the backdrop.
void pass_backdrop(const PassContext& pass);
// Exposure, bloom, tone curve and transfer function of `sum` (or of the lone sub-frame, composed) into the film; of a plan for
// the glow, what glows.
void pass_resolve(const PassContext& pass);

}  // namespace furnace
