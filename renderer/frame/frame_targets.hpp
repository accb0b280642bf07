// The render targets of a frame's tiles, kept from frame to frame while their shape stays.
#pragma once

#include "renderer/frame/frame_plan.hpp"
#include "renderer/gl/texture.hpp"

namespace furnace {

// Threads: the context's. Owns: its textures and framebuffers.
struct FrameTargets {
  Extent size;
  int msaa_samples = 0;
  SampleType film_type = SampleType::kUint8;

  gl::Texture color, depth;  // RGBA32F and depth, multisampled: one sub-frame
  gl::Texture accumulated;   // RGBA32F: the mean of the sub-frames
  gl::Texture film;          // what is read back
  gl::Framebuffer draw, accumulate, resolve;

  bool fits(const FramePlan& plan) const;
};

FrameTargets create_frame_targets(gl::Context& context, const FramePlan& plan);

}  // namespace furnace
