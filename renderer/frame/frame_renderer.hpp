// Runs a plan: reads as the list of passes.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "renderer/frame/film_layers.hpp"
#include "renderer/frame/frame_plan.hpp"
#include "renderer/frame/frame_targets.hpp"
#include "renderer/gl/program.hpp"
#include "renderer/residency/draw_list.hpp"

namespace furnace {

// A scene as a camera sees it at one time.
struct FrameSubject {
  const View& view;
  const GpuScene& scene;
  const PreparedScene& prepared;
};

struct FrameResult {
  // RGBA of the plan's film_type, straight alpha for kUint8/16, premultiplied else; of a film layer's numbers what view_of() makes.
  Image pixels;
  std::vector<ImageLayer> layers;     // of the plan
  std::vector<TextField> attributes;  // that belong to them
  double draw_ms = 0, readback_ms = 0;
};

struct PassContext;

// Threads: the context's. Owns: render targets.
class FrameRenderer {
 public:
  FrameRenderer(gl::Context& context, gl::ProgramCache& programs);

  // `middle`: of the shutter; what a lone sub-frame sees, and places. `moments`: what several see, each its own
  // (scene/shutter.hpp); empty where nothing moves. `earlier`: what motion vectors look back at, or null.
  // Errors: kDeadlineExceeded between sub-frames.
  FrameResult render(Residency& residency, const FramePlan& plan, const FrameSubject& middle,
                     std::span<const FrameSubject> moments, const EarlierScene* earlier,
                     const Deadline& deadline);

  // Draws the ground's shadow where the scene wants one and has none yet. Errors: kDeadlineExceeded.
  void provide_ground_shadow(Residency& residency, const PreparedScene& prepared, GpuScene& scene,
                             const Deadline& deadline);

 private:
  // What one frame is drawn of; lives as long as the call.
  struct FrameJob {
    Residency& residency;
    const FramePlan& plan;
    const FrameSubject& middle;
    std::span<const FrameSubject> moments;
    std::vector<int> moment_of;  // of each sub-frame; empty where nothing moves
    const Deadline& deadline;
    FrameTargets& targets;
    FilmLayers& layers;
    const gl::Texture* sky_sums;  // as PassContext's

    const FrameSubject& subject(std::size_t subframe) const {
      return moment_of.empty() ? middle : moments[std::size_t(moment_of[subframe])];
    }
    std::size_t moment(std::size_t subframe) const {
      return moment_of.empty() ? 0 : std::size_t(moment_of[subframe]);
    }
  };
  // What a drawing of a sub-frame is for.
  enum class Purpose {
    kPicture,
    kBackdrop,           // of all sub-frames
    kBackdropOfSubframe  // of this one alone
  };
  struct LightBuffers {
    gl::Buffer lights, sky;
  };
  LightBuffers draw_shadows(const FrameJob& job, const PassContext& pass, std::size_t subframe);
  // Whether it was drawn.
  bool provide_visibility(const FrameJob& job, const PassContext& pass, const PreparedScene& prepared);
  void draw_backdrop(const FrameJob& job);
  void draw_backdrop_of(const FrameJob& job, std::size_t subframe);
  void draw_places(const FrameJob& job, const Tile& tile);
  void draw_layers(const FrameJob& job, const PassContext& pass, std::size_t subframe);
  void resolve(const FrameJob& job, const PassContext& pass);
  void read_tile(const FrameJob& job, const Tile& tile, Image& pixels);
  void draw_subframe(const FrameJob& job, const FramePlan& plan, const Tile& tile, std::size_t subframe,
                     Purpose purpose, const gl::Texture* glow);

  gl::Context& context_;
  gl::ProgramCache& programs_;
  gl::VertexArray empty_vertex_array_;
  std::optional<FrameTargets> picture_targets_, glow_targets_;
};

}  // namespace furnace
