#include "renderer/frame/frame_renderer.hpp"

#include <algorithm>

#include "renderer/frame/frame_uniform.hpp"
#include "renderer/frame/ground_shadow.hpp"
#include "renderer/frame/passes.hpp"
#include "renderer/gl/readback.hpp"

namespace furnace {
namespace {

constexpr GLuint kFrameBinding = 0, kLightBinding = 4;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

PassContext emission_of(PassContext pass) {
  pass.emission = true;
  return pass;
}

void shade_and_accumulate(const PassContext& pass, std::size_t subframe) {
  pass_veil(pass);
  pass_shade(pass);
  pass_accumulate(pass, subframe);
}

}  // namespace

FrameRenderer::FrameRenderer(gl::Context& context, gl::ProgramCache& programs)
    : context_(context), programs_(programs), empty_vertex_array_(gl::create_vertex_array(context)) {}

FrameResult FrameRenderer::render(Residency& residency, const FramePlan& plan, const View& view,
                                  const GpuScene& scene, const PreparedScene& prepared,
                                  const Deadline& deadline) {
  const GroundRectangle* ground_map =
      scene.ground_shadow != nullptr ? &scene.ground_shadow->rectangle : nullptr;
  const std::size_t subframes = plan.jitter_px.size();
  const bool emission = plan.bloom && plan.bloom->source == BloomSource::kEmission;
  // The glow's are of one size or few, and kept beside the picture's.
  std::optional<FrameTargets>& targets = plan.glow_only ? glow_targets_ : picture_targets_;
  provide_targets(context_, plan, {!scene.blended.empty() || !scene.strokes.empty(), subframes > 1, emission},
                  targets);
  gl::Texture glow;
  if (plan.bloom && !plan.glow_only) glow = gl::upload_texture(context_, plan.bloom->glow, false);
  FrameResult result;
  result.pixels = make_image(plan.picture, 4, plan.film_type,
                             plan.scene_linear() ? ColorSpace::kLinear : ColorSpace::kSrgb);
  for (const Tile& tile : plan.tiles) {
    const Clock::time_point start = Clock::now();
    for (std::size_t subframe = 0; subframe < subframes; ++subframe) {
      check_deadline(deadline, "draw");
      const gpu::FrameBlock frame = pack_frame(plan, view, prepared, ground_map, tile, subframe);
      const gl::Buffer uniform = gl::create_buffer(context_, &frame, sizeof frame);
      glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, uniform.id());
      const PassContext pass{context_, programs_, residency,           plan,  *targets,
                             scene,    tile,      empty_vertex_array_, frame, &glow};
      gl::Buffer light_uniform;
      if (!prepared.lights.empty()) {
        const LightPlan lights =
            plan_lights(prepared.lights, prepared.bounds, {tile.x, tile.y}, int(subframe), int(subframes));
        provide_shadows(context_, lights.side_px, std::max(lights.views, 1), *targets);
        light_uniform = gl::create_buffer(context_, &lights.block, sizeof lights.block);
        glBindBufferBase(GL_UNIFORM_BUFFER, kLightBinding, light_uniform.id());
        // A lone sub-frame's maps are the same for every tile.
        if (subframes > 1 || &tile == &plan.tiles.front()) pass_shadow(pass, lights);
      }
      pass_visibility(pass);
      if (emission) shade_and_accumulate(emission_of(pass), subframe);
      if (!(emission && plan.glow_only)) shade_and_accumulate(pass, subframe);
      glFinish();
      if (subframe + 1 == subframes) pass_resolve(pass);
    }
    glFinish();
    result.draw_ms += ms_since(start);

    const Clock::time_point read_start = Clock::now();
    gl::read_pixels(context_, targets->film.framebuffer, tile.size, result.pixels, tile.x, tile.y);
    result.readback_ms += ms_since(read_start);
  }
  return result;
}

void FrameRenderer::provide_ground_shadow(Residency& residency, const PreparedScene& prepared,
                                          GpuScene& scene, const Deadline& deadline) {
  if (scene.ground_shadow != nullptr || !prepared.ground || prepared.ground->light == nullptr) return;
  GpuGroundShadow shadow = draw_ground_shadow(context_, programs_, residency, scene, *prepared.ground,
                                              empty_vertex_array_, deadline);
  scene.ground_shadow = residency.keep_ground_shadow(*prepared.ground->shadow_key, std::move(shadow));
}

}  // namespace furnace
