#include "renderer/frame/frame_renderer.hpp"

#include <algorithm>

#include "renderer/frame/frame_uniform.hpp"
#include "renderer/frame/ground_shadow.hpp"
#include "renderer/frame/light_plan.hpp"
#include "renderer/frame/passes.hpp"
#include "renderer/frame/sky_plan.hpp"
#include "renderer/gl/readback.hpp"

namespace furnace {
namespace {

constexpr GLuint kFrameBinding = 0, kLightBinding = 4, kSkyBinding = 5;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
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
  provide_targets(context_, plan, {!scene.blended.empty() || !scene.strokes.empty(), subframes > 1},
                  targets_);
  std::optional<gl::Texture> sky_sums;
  if (plan.sky_views > 0 && !prepared.sky_lights.empty() && !prepared.bounds.empty())
    sky_sums = gl::upload_texture(context_, prepared.sky_sums.maps, false);
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
      const PassContext pass{
          context_, programs_, residency,           plan,  *targets_,
          scene,    tile,      empty_vertex_array_, frame, sky_sums ? &*sky_sums : nullptr};
      gl::Buffer light_uniform;
      if (!prepared.lights.empty()) {
        const LightPlan lights =
            plan_lights(prepared.lights, prepared.bounds, {tile.x, tile.y}, int(subframe), int(subframes));
        provide_shadows(context_, GL_DEPTH_COMPONENT32F, lights.side_px, std::max(lights.views, 1),
                        targets_->shadows);
        light_uniform = gl::create_buffer(context_, &lights.block, sizeof lights.block);
        glBindBufferBase(GL_UNIFORM_BUFFER, kLightBinding, light_uniform.id());
        // A lone sub-frame's maps are the same for every tile.
        if (subframes > 1 || &tile == &plan.tiles.front())
          pass_shadow(pass, *targets_->shadows,
                      std::span(lights.block.shadow_from_world).first(std::size_t(lights.views)),
                      Casters::kExact);
      }
      gl::Buffer sky_uniform;
      if (sky_sums) {
        const SkyPlan sky = plan_sky(prepared.sky_lights, prepared.bounds, prepared.sky_sums.least_alpha,
                                     int(subframe), int(subframes));
        provide_shadows(context_, GL_DEPTH_COMPONENT16, kSkyMapPx, int(sky.clip_from_world.size()),
                        targets_->sky_shadows);
        sky_uniform = gl::create_buffer(context_, &sky.block, sizeof sky.block);
        glBindBufferBase(GL_UNIFORM_BUFFER, kSkyBinding, sky_uniform.id());
        pass_shadow(pass, *targets_->sky_shadows, sky.clip_from_world, Casters::kSimplified);
      }
      pass_visibility(pass);
      pass_veil(pass);
      pass_shade(pass);
      pass_accumulate(pass, subframe == 0);
      glFinish();
      if (subframe + 1 == subframes) pass_resolve(pass);
    }
    glFinish();
    result.draw_ms += ms_since(start);

    const Clock::time_point read_start = Clock::now();
    gl::read_pixels(context_, targets_->film.framebuffer, tile.size, result.pixels, tile.x, tile.y);
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
