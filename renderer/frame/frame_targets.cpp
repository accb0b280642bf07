#include "renderer/frame/frame_targets.hpp"

namespace furnace {
namespace {

GLenum film_format(SampleType type) {
  switch (type) {
    case SampleType::kFloat16:
      return GL_RGBA16F;
    case SampleType::kFloat32:
      return GL_RGBA32F;
    default:
      return GL_RGBA8;
  }
}

}  // namespace

bool FrameTargets::fits(const FramePlan& plan) const {
  return size == plan.tile_size && msaa_samples == plan.msaa_samples && film_type == plan.film_type;
}

FrameTargets create_frame_targets(gl::Context& context, const FramePlan& plan) {
  FrameTargets targets;
  targets.size = plan.tile_size;
  targets.msaa_samples = plan.msaa_samples;
  targets.film_type = plan.film_type;
  // Single precision: a sun of 2e5 overflows half floats, and a scale that saved it would cost the shadows their bits.
  targets.color = gl::create_target(context, GL_RGBA32F, plan.tile_size, plan.msaa_samples);
  targets.depth = gl::create_target(context, GL_DEPTH_COMPONENT32F, plan.tile_size, plan.msaa_samples);
  targets.accumulated = gl::create_target(context, GL_RGBA32F, plan.tile_size, 1);
  targets.film = gl::create_target(context, film_format(plan.film_type), plan.tile_size, 1);
  targets.draw = gl::create_framebuffer(context, targets.color, targets.depth);
  targets.accumulate = gl::create_framebuffer(context, targets.accumulated, {});
  targets.resolve = gl::create_framebuffer(context, targets.film, {});
  return targets;
}

}  // namespace furnace
