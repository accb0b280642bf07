#include "renderer/frame/frame_renderer.hpp"

#include <algorithm>

#include "renderer/frame/covered_pixels.hpp"
#include "renderer/frame/frame_uniform.hpp"
#include "renderer/frame/ground_shadow.hpp"
#include "renderer/frame/layer_view.hpp"
#include "renderer/frame/light_plan.hpp"
#include "renderer/frame/passes.hpp"
#include "renderer/frame/sky_plan.hpp"
#include "renderer/gl/readback.hpp"
#include "renderer/scene/shutter.hpp"

namespace furnace {
namespace {

constexpr GLuint kFrameBinding = 0, kLightBinding = 4, kSkyBinding = 6;
constexpr int kBackdropSidePx = 2048;

// lib/visibility.glsl: key_of().
std::uint32_t key_of_visibility(std::uint32_t y) {
  constexpr int kNormalBits = 14;
  return y >> kNormalBits;
}

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

PassContext emission_of(PassContext pass) {
  pass.emission = true;
  pass.sum = &*pass.targets.emission;
  pass.lobes = nullptr;
  return pass;
}

// The film layer of place i among the plan's sources.
PassContext layer_of(PassContext pass, std::size_t i) {
  pass.shown = pass.plan.layers.sources[i];
  pass.sum = &pass.targets.layers[i];
  pass.lobes = nullptr;
  return pass;
}

void shade_and_accumulate(const PassContext& pass, std::size_t subframe) {
  pass_veil(pass);
  pass_shade(pass);
  if (pass.sum != nullptr) pass_accumulate(pass, subframe);
}

// Uploads the block and binds it; it lives as long as what is returned.
gl::Buffer bind_frame(gl::Context& context, const gpu::FrameBlock& frame) {
  gl::Buffer uniform = gl::create_buffer(context, &frame, sizeof frame);
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, uniform.id());
  return uniform;
}

}  // namespace

FrameRenderer::FrameRenderer(gl::Context& context, gl::ProgramCache& programs)
    : context_(context), programs_(programs), empty_vertex_array_(gl::create_vertex_array(context)) {}

// What shines on the sub-frame, and the maps of what it casts shadows of.
FrameRenderer::LightBuffers FrameRenderer::draw_shadows(const FrameJob& job, const PassContext& pass,
                                                        std::size_t subframe) {
  const PreparedScene& prepared = job.subject(subframe).prepared;
  const std::size_t subframes = pass.plan.jitter_px.size();
  LightPlan lights;
  if (!prepared.lights.empty())
    lights = plan_lights(prepared.lights, prepared.bounds, {pass.tile.x, pass.tile.y}, int(subframe),
                         int(subframes));
  SkyPlan sky;
  const bool sky_casts = pass.sky_sums != nullptr;
  if (sky_casts) {
    if (prepared.lights.empty()) lights.side_px = kSkyMapPx;
    sky = plan_sky(prepared.sky_lights, prepared.bounds, job.middle.prepared.sky_sums.least_alpha,
                   lights.views, lights.side_px, int(subframe), int(subframes));
  }
  LightBuffers buffers;
  if (prepared.lights.empty() && !sky_casts) return buffers;
  const int sky_views = int(sky.clip_from_world.size());
  provide_shadows(context_, lights.side_px, std::max(lights.views + sky_views, 1), job.targets);
  if (!prepared.lights.empty()) {
    buffers.lights = gl::create_buffer(context_, &lights.block, sizeof lights.block);
    glBindBufferBase(GL_UNIFORM_BUFFER, kLightBinding, buffers.lights.id());
  }
  if (sky_casts) {
    buffers.sky = gl::create_buffer(context_, &sky.block, sizeof sky.block);
    glBindBufferBase(GL_UNIFORM_BUFFER, kSkyBinding, buffers.sky.id());
  }
  // A lone sub-frame's maps are the same for every tile.
  const Tile& first = pass.plan.tiles.front();
  if (subframes == 1 && (pass.tile.x != first.x || pass.tile.y != first.y)) return buffers;
  pass_shadow(pass, std::span(lights.block.shadow_from_world).first(std::size_t(lights.views)), 0,
              Casters::kExact);
  pass_shadow(pass, sky.clip_from_world, lights.views, Casters::kSimplified);
  return buffers;
}

// A lone sub-frame leaves its visibility to the next picture: of one view they differ in materials, light and film only.
bool FrameRenderer::provide_visibility(const FrameJob& job, const PassContext& pass,
                                       const PreparedScene& prepared) {
  const bool is_lone = pass.plan.tiles.size() == 1 && pass.plan.jitter_px.size() == 1;
  const std::optional<ContentHash> key =
      is_lone ? visibility_key(pass, prepared) : std::optional<ContentHash>();
  if (key && job.targets.seen == key) return false;
  job.targets.seen.reset();
  pass_visibility(pass, VisibleSurfaces::kAll);
  job.targets.seen = key;
  return true;
}

// One sub-frame of one tile, accumulated where there are several. `glow`: of the whole picture, empty where there is no bloom; null
// for a backdrop.
void FrameRenderer::draw_subframe(const FrameJob& job, const FramePlan& plan, const Tile& tile,
                                  std::size_t subframe, Purpose purpose, const gl::Texture* glow) {
  check_deadline(job.deadline, "draw");
  const std::size_t subframes = plan.jitter_px.size();
  const FrameSubject& subject = job.subject(subframe);
  const bool alone = purpose == Purpose::kBackdropOfSubframe;
  if (purpose == Purpose::kPicture && !job.moment_of.empty() && subject.scene.nearest_glass_m)
    draw_backdrop_of(job, subframe);
  const GroundRectangle* ground_map =
      subject.scene.ground_shadow != nullptr ? &subject.scene.ground_shadow->rectangle : nullptr;
  const gpu::FrameBlock frame = pack_frame(plan, subject.view, subject.prepared, ground_map, tile, subframe);
  const gl::Buffer uniform = bind_frame(context_, frame);
  PassContext pass{context_,
                   programs_,
                   job.residency,
                   plan,
                   job.targets,
                   subject.scene,
                   tile,
                   empty_vertex_array_,
                   frame,
                   glow,
                   purpose != Purpose::kPicture};
  if (!subject.prepared.bounds.empty()) pass.sky_sums = job.sky_sums;
  pass.veil = veiled_pixels(frame, tile.size, subject.scene);
  pass.alone = alone;
  if (alone) {
    pass.sum = &*job.targets.behind;
  } else if (subframes > 1 || pass.is_backdrop) {
    pass.sum = &*job.targets.accumulated;
    if (plan.has_lobes()) pass.lobes = &*job.targets.lobes;
  }
  const LightBuffers lights = draw_shadows(job, pass, subframe);
  const bool is_fresh = provide_visibility(job, pass, subject.prepared);
  if (!pass.is_backdrop) draw_layers(job, pass, subframe);
  const bool emission = !pass.is_backdrop && plan.bloom && plan.bloom->source == BloomSource::kEmission;
  pass.first_is_selected = is_fresh && (pass.is_backdrop || (plan.layers.sources.empty() && !emission));
  if (emission) shade_and_accumulate(emission_of(pass), subframe);
  const bool picture = pass.is_backdrop || (plan.layers.needs_picture() && !(emission && plan.glow_only));
  if (picture) shade_and_accumulate(pass, subframe);
  glFinish();
  if (subframe + 1 < subframes && !alone) return;
  if (picture && pass.lobes != nullptr) pass_limit_lobes(pass);
  if (pass.is_backdrop) {
    pass_backdrop(pass);
  } else {
    resolve(job, pass);
  }
  glFinish();
}

// Who covers the sub-frame, and what its surfaces show in place of radiance.
void FrameRenderer::draw_layers(const FrameJob& job, const PassContext& pass, std::size_t subframe) {
  const LayerPlan& layers = pass.plan.layers;
  if (layers.any_matte()) {
    const Extent samples{2 * pass.tile.size.width, 2 * pass.tile.size.height};
    constexpr int kKeys = 1;
    std::vector<std::uint32_t> keys =
        gl::read_numbers(context_, pass.targets.visibility.framebuffer, samples, kKeys);
    for (std::uint32_t& key : keys) key = key_of_visibility(key);
    job.layers.add_to_mattes(keys, pass.plan.weights[subframe], job.moment(subframe));
  }
  for (std::size_t i = 0; i < layers.sources.size(); ++i) {
    const FilmLayer source = layers.sources[i];
    if (row_of(source).kind == FilmLayerKind::kPlace || source == FilmLayer::kGlow) continue;
    check_deadline(job.deadline, "draw");
    shade_and_accumulate(layer_of(pass, i), subframe);
    glFinish();
  }
}

// What is where, as the middle of the lens sees it: of each pixel the surface nearest to it.
void FrameRenderer::draw_places(const FrameJob& job, const Tile& tile) {
  View pinhole = job.middle.view;
  pinhole.lens = {};
  FramePlan still = job.plan;
  set_samples(still, 1, {});
  const gpu::FrameBlock frame = pack_frame(still, pinhole, job.middle.prepared, nullptr, tile, 0);
  const gl::Buffer uniform = bind_frame(context_, frame);
  const PassContext pass{context_,         programs_, job.residency,       job.plan, job.targets,
                         job.middle.scene, tile,      empty_vertex_array_, frame};
  job.targets.seen.reset();
  pass_visibility(pass, VisibleSurfaces::kNearest);
  for (std::size_t i = 0; i < job.plan.layers.sources.size(); ++i) {
    if (row_of(job.plan.layers.sources[i]).kind != FilmLayerKind::kPlace) continue;
    check_deadline(job.deadline, "draw");
    const PassContext places = layer_of(pass, i);
    pass_shade(places);
    pass_keep(places);
    glFinish();
  }
}

// The picture of all sub-frames, or the film layer that stands in its place.
void FrameRenderer::resolve(const FrameJob& job, const PassContext& pass) {
  const LayerPlan& layers = pass.plan.layers;
  if (const auto glow = layers.place_of(FilmLayer::kGlow)) pass_glow(pass, job.targets.layers[*glow]);
  if (!layers.shown) {
    pass_resolve(pass);
  } else if (layers.shows_radiance()) {
    pass_resolve(layer_of(pass, *layers.place_of(source_of(*layers.shown))));
  }
}

void FrameRenderer::read_tile(const FrameJob& job, const Tile& tile, Image& pixels) {
  const LayerPlan& layers = job.plan.layers;
  if (!layers.shown || layers.shows_radiance())
    gl::read_pixels(context_, job.targets.film.framebuffer, tile.size, pixels, tile.x, tile.y);
  if (layers.sources.empty()) return;
  const auto read = [&](std::size_t source) {
    Image drawn = make_image(tile.size, 4, SampleType::kFloat32, ColorSpace::kNonColor);
    gl::read_pixels(context_, job.targets.layers[source].framebuffer, tile.size, drawn, 0, 0);
    return drawn;
  };
  for (std::size_t i = 0; i < layers.sources.size(); ++i) job.layers.store(layers.sources[i], read(i), tile);
  if (layers.wants(FilmLayer::kMotion))
    job.layers.store_motion(read(*layers.place_of(FilmLayer::kPosition)),
                            read(*layers.place_of(FilmLayer::kPrimitiveId)), tile);
}

void FrameRenderer::draw_backdrop(const FrameJob& job) {
  const FramePlan plan = scaled_plan(job.plan, kBackdropSidePx);
  provide_backdrop(context_, plan.picture, job.targets);
  for (const Tile& tile : plan.tiles) {
    for (std::size_t i = 0; i < plan.jitter_px.size(); ++i)
      draw_subframe(job, plan, tile, i, Purpose::kBackdrop, nullptr);
  }
  glGenerateTextureMipmap(job.targets.backdrop->color.id());
}

// Of what moves: what stands behind the glass now.
void FrameRenderer::draw_backdrop_of(const FrameJob& job, std::size_t subframe) {
  const FramePlan plan = scaled_plan(job.plan, kBackdropSidePx);
  provide_backdrop(context_, plan.picture, job.targets);
  for (const Tile& tile : plan.tiles)
    draw_subframe(job, plan, tile, subframe, Purpose::kBackdropOfSubframe, nullptr);
  glGenerateTextureMipmap(job.targets.backdrop->color.id());
}

FrameResult FrameRenderer::render(Residency& residency, const FramePlan& plan, const FrameSubject& middle,
                                  std::span<const FrameSubject> moments, const EarlierScene* earlier,
                                  const Deadline& deadline) {
  const std::size_t subframes = plan.jitter_px.size();
  if (subframes == 1) moments = {};
  const std::span<const FrameSubject> seen = moments.empty() ? std::span(&middle, 1) : moments;
  const auto any = [&](auto has) { return std::any_of(seen.begin(), seen.end(), has); };
  const bool veil =
      any([](const FrameSubject& one) { return !one.scene.blended.empty() || !one.scene.strokes.empty(); });
  const bool glass = any([](const FrameSubject& one) { return one.scene.nearest_glass_m.has_value(); });
  const bool emission = plan.bloom && plan.bloom->source == BloomSource::kEmission;
  // The glow's are of one size or few, and kept beside the picture's.
  std::optional<FrameTargets>& targets = plan.glow_only ? glow_targets_ : picture_targets_;
  provide_targets(context_, plan,
                  {veil, subframes > 1 || glass, emission, plan.has_lobes(), glass && !moments.empty(),
                   plan.layers.sources.size()},
                  targets);
  std::vector<const PreparedScene*> scenes;
  for (const FrameSubject& one : seen) scenes.push_back(&one.prepared);
  FilmLayers layers(plan, {middle.view, middle.prepared, earlier}, scenes);
  const auto hides = [](const FrameSubject& one) { return !one.prepared.bounds.empty(); };
  std::optional<gl::Texture> sky_sums;
  if (plan.sky_shadows && !middle.prepared.sky_lights.empty() && any(hides))
    sky_sums = gl::upload_texture(context_, middle.prepared.sky_sums.maps, false);
  std::vector<int> moment_of;
  if (!moments.empty()) moment_of = moment_of_subframes(int(subframes), int(moments.size()));
  const FrameJob job{residency,
                     plan,
                     middle,
                     moments,
                     std::move(moment_of),
                     deadline,
                     *targets,
                     layers,
                     sky_sums ? &*sky_sums : nullptr};
  gl::Texture glow;
  if (plan.bloom && !plan.glow_only) glow = gl::upload_texture(context_, plan.bloom->glow, false);
  FrameResult result;
  result.pixels = make_image(plan.picture, 4, plan.film_type,
                             plan.scene_linear() ? ColorSpace::kLinear : ColorSpace::kSrgb);
  const Clock::time_point backdrop_start = Clock::now();
  if (glass && moments.empty()) draw_backdrop(job);
  result.draw_ms += ms_since(backdrop_start);
  for (const Tile& tile : plan.tiles) {
    const Clock::time_point start = Clock::now();
    layers.begin_mattes(tile);
    if (plan.layers.any(FilmLayerKind::kPlace)) draw_places(job, tile);
    for (std::size_t i = 0; i < subframes; ++i) draw_subframe(job, plan, tile, i, Purpose::kPicture, &glow);
    result.draw_ms += ms_since(start);

    const Clock::time_point read_start = Clock::now();
    read_tile(job, tile, result.pixels);
    layers.store_mattes(tile);
    result.readback_ms += ms_since(read_start);
  }
  if (plan.layers.shown && !plan.layers.shows_radiance())
    result.pixels = view_of(layers.shown(), plan, middle.view, middle.prepared.bounds);
  result.attributes = layers.attributes();
  result.layers = layers.take_layers();
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
