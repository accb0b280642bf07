#include "renderer/frame/frame_renderer.hpp"

#include "renderer/frame/frame_uniform.hpp"
#include "renderer/frame/passes.hpp"
#include "renderer/gl/readback.hpp"

namespace furnace {
namespace {

constexpr GLuint kFrameBinding = 0;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct FrameUniform {
  gl::Buffer buffer;
  float sky_lod;
};

std::vector<FrameUniform> upload_uniforms(gl::Context& context, const FramePlan& plan, const View& view,
                                          const PreparedEnvironment& environment) {
  std::vector<FrameUniform> uniforms;
  for (std::size_t subframe = 0; subframe < plan.jitter_px.size(); ++subframe) {
    const gpu::FrameBlock block = pack_frame(plan, view, environment, subframe);
    uniforms.push_back({gl::create_buffer(context, &block, sizeof block), block.sky_lod});
  }
  return uniforms;
}

}  // namespace

FrameRenderer::FrameRenderer(gl::Context& context, gl::ProgramCache& programs)
    : context_(context), programs_(programs), empty_vertex_array_(gl::create_vertex_array(context)) {}

FrameResult FrameRenderer::render(Residency& residency, const FramePlan& plan, const View& view,
                                  const GpuScene& scene, const PreparedEnvironment& environment,
                                  const Deadline& deadline) {
  if (!targets_ || !targets_->fits(plan)) {
    targets_.reset();
    targets_ = create_frame_targets(context_, plan);
  }
  FrameResult result;
  result.pixels = make_image(plan.picture, 4, plan.film_type,
                             plan.film_type == SampleType::kUint8 ? ColorSpace::kSrgb : ColorSpace::kLinear);
  const std::vector<FrameUniform> uniforms = upload_uniforms(context_, plan, view, environment);
  for (const Tile& tile : plan.tiles) {
    const Clock::time_point start = Clock::now();
    for (std::size_t subframe = 0; subframe < uniforms.size(); ++subframe) {
      check_deadline(deadline, "draw");
      glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, uniforms[subframe].buffer.id());
      const PassContext pass{context_, programs_,           residency,
                             plan,     *targets_,           scene,
                             tile,     empty_vertex_array_, uniforms[subframe].sky_lod};
      pass_surface_opaque(pass);
      pass_surface_blended(pass);
      pass_accumulate(pass, subframe == 0);
      glFinish();
      if (subframe + 1 == uniforms.size()) pass_resolve(pass);
    }
    glFinish();
    result.draw_ms += ms_since(start);

    const Clock::time_point read_start = Clock::now();
    gl::read_pixels(context_, targets_->resolve, tile.size, result.pixels, tile.x, tile.y);
    result.readback_ms += ms_since(read_start);
  }
  return result;
}

}  // namespace furnace
