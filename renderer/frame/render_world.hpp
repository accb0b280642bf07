// What a GL thread owns: its context and everything that lives in it.
#pragma once

#include <memory>

#include "renderer/frame/frame_renderer.hpp"

namespace furnace {

struct RenderWorldConfig {
  gl::ContextConfig gl;
  std::string shader_dir;
  std::int64_t gpu_cache_bytes = 0;
};

// Threads: the one that made it. Owns: all of it, destroyed in reverse.
class RenderWorld {
 public:
  RenderWorld(const RenderWorldConfig& config, std::shared_ptr<ResidentKeys> keys)
      : context_(gl::Context::create(config.gl)),
        programs_(config.shader_dir),
        residency_(*context_, config.gpu_cache_bytes, std::move(keys)),
        frames_(*context_, programs_) {}

  gl::Context& context() { return *context_; }
  gl::ProgramCache& programs() { return programs_; }
  Residency& residency() { return residency_; }
  FrameRenderer& frames() { return frames_; }

 private:
  std::unique_ptr<gl::Context> context_;
  gl::ProgramCache programs_;
  Residency residency_;
  FrameRenderer frames_;
};

}  // namespace furnace
