#include "renderer/frame/frame_targets.hpp"

namespace furnace {
namespace {

// Single precision: a sun of 2e5 overflows half floats, and a scale that saved it would cost the shadows their bits.
constexpr GLenum kRadiance = GL_RGBA32F;

GLenum film_format(SampleType type) {
  switch (type) {
    case SampleType::kUint16:
      return GL_RGBA16;
    case SampleType::kFloat16:
      return GL_RGBA16F;
    case SampleType::kFloat32:
      return GL_RGBA32F;
    default:
      return GL_RGBA8;
  }
}

Extent samples_of(Extent pixels) {
  return {2 * pixels.width, 2 * pixels.height};
}

ColorTarget create_color_target(gl::Context& context, GLenum format, Extent size) {
  ColorTarget target;
  target.color = gl::create_texture(context, format, size, 1);
  target.framebuffer = gl::create_framebuffer(context, target.color, {});
  return target;
}

FrameTargets create_frame_targets(gl::Context& context, const FramePlan& plan) {
  FrameTargets targets;
  targets.size = plan.tile_size;
  targets.film_type = plan.film_type;
  VisibilityTarget& visibility = targets.visibility;
  visibility.texels = gl::create_texture(context, GL_RG32UI, samples_of(plan.tile_size), 1);
  visibility.depth = gl::create_texture(context, GL_DEPTH_COMPONENT32F, samples_of(plan.tile_size), 1);
  visibility.framebuffer = gl::create_framebuffer(context, visibility.texels, visibility.depth);
  ShadingTarget& shading = targets.shading;
  shading.shares = gl::create_texture(context, GL_R16UI, plan.tile_size, 1);
  shading.selection = gl::create_texture(context, GL_DEPTH_COMPONENT32F, plan.tile_size, 1);
  shading.color = gl::create_texture(context, kRadiance, plan.tile_size, 1);
  shading.share = gl::create_framebuffer(context, shading.shares, shading.selection);
  shading.select = gl::create_framebuffer(context, {}, shading.selection);
  shading.shade = gl::create_framebuffer(context, shading.color, shading.selection);
  targets.film = create_color_target(context, film_format(plan.film_type), plan.tile_size);
  return targets;
}

}  // namespace

void provide_targets(gl::Context& context, const FramePlan& plan, TargetNeeds needs,
                     std::optional<FrameTargets>& targets) {
  if (!targets || targets->size != plan.tile_size || targets->film_type != plan.film_type) {
    targets.reset();
    targets = create_frame_targets(context, plan);
  }
  if (needs.veil && !targets->veil) {
    VeilTarget veil;
    veil.color = gl::create_texture(context, GL_RGBA16F, samples_of(plan.tile_size), 1);
    veil.framebuffer = gl::create_framebuffer(context, veil.color, targets->visibility.depth);
    veil.pixels = gl::create_texture(context, GL_RGBA32UI, plan.tile_size, 1);
    veil.gather = gl::create_framebuffer(context, veil.pixels, {});
    targets->veil = std::move(veil);
  }
  if (needs.accumulated && !targets->accumulated)
    targets->accumulated = create_color_target(context, kRadiance, plan.tile_size);
  if (needs.emission && !targets->emission)
    targets->emission = create_color_target(context, kRadiance, plan.tile_size);
  if (needs.lobes && !targets->lobes)
    targets->lobes = create_color_target(context, kRadiance, plan.tile_size);
  if (needs.behind && !targets->behind)
    targets->behind = create_color_target(context, kRadiance, plan.tile_size);
  if (targets->layers.size() > needs.layers) targets->layers.resize(needs.layers);
  while (targets->layers.size() < needs.layers)
    targets->layers.push_back(create_color_target(context, kRadiance, plan.tile_size));
}

void provide_backdrop(gl::Context& context, Extent size, FrameTargets& targets) {
  if (targets.backdrop && targets.backdrop->size == size) return;
  targets.backdrop.reset();
  targets.backdrop = BackdropTarget{size, gl::create_texture(context, kRadiance, size, gl::mip_levels(size))};
}

void provide_shadows(gl::Context& context, int side_px, int views, FrameTargets& targets) {
  if (targets.shadows && targets.shadows->side_px == side_px && targets.shadows->views >= views) return;
  targets.shadows.reset();
  ShadowTarget shadows;
  shadows.side_px = side_px;
  shadows.views = views;
  shadows.maps = gl::create_texture_array(context, GL_DEPTH_COMPONENT32F, {side_px, side_px}, views);
  const GLuint maps = shadows.maps.id();
  glTextureParameteri(maps, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTextureParameteri(maps, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);  // depth is reversed: nearer is larger
  glTextureParameteri(maps, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(maps, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(maps, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(maps, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  shadows.framebuffer = gl::Framebuffer(framebuffer);
  glNamedFramebufferDrawBuffer(framebuffer, GL_NONE);
  targets.shadows = std::move(shadows);
}

}  // namespace furnace
