#include "renderer/renderer.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "renderer/frame/bloom.hpp"
#include "renderer/frame/exposure.hpp"
#include "renderer/frame/render_world.hpp"
#include "renderer/scene/framing.hpp"
#include "renderer/scene/shutter.hpp"
#include "renderer/context_pool.hpp"
#include "renderer/scene_store.hpp"

namespace furnace {
namespace {

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// What came back from the GL thread: a picture, or the news that something must be done first.
struct GlOutcome {
  enum class Kind { kDone, kEvicted, kContextLost } kind = Kind::kDone;
  FrameResult frame;
  double exposure_ev = 0;
  double queue_ms = 0, upload_ms = 0;
  bool upload_hit = false;
};

// One framing for all that is seen while the shutter is open; a camera of the model moves as its node does.
// Threads: one. Owns: the swept scene.
class Framing {
 public:
  Framing(const RenderSpec& spec, const Preparation& preparation) : spec_(spec) {
    std::vector<const Scene*> scenes;
    for (const PreparedMoment& moment : preparation.moments) scenes.push_back(&moment.composed->scene);
    if (scenes.empty()) {
      middle_ = view_of(preparation.composed->scene);
    } else {
      swept_ = swept_scene(preparation.composed->scene, scenes);
      middle_ = view_of(*swept_);
    }
  }

  const View& middle() const { return middle_; }
  View at(const Scene& then, double offset_s) {
    if (!std::holds_alternative<GltfCamera>(spec_.camera.view))
      return view_at(middle_, spec_.camera.motion, offset_s);
    if (!swept_) swept_ = then;
    swept_->cameras = then.cameras;
    return view_of(*swept_);
  }

 private:
  View view_of(const Scene& scene) const {
    return make_view(spec_.camera, scene, {spec_.output.width, spec_.output.height});
  }

  const RenderSpec& spec_;
  std::optional<Scene> swept_;
  View middle_;
};

struct Views {
  View middle;
  std::vector<View> moments;  // of Preparation::moments
};

bool wants_motion(const OutputSpec& output) {
  return output.shown == FilmLayer::kMotion ||
         std::find(output.layers.begin(), output.layers.end(), FilmLayer::kMotion) != output.layers.end();
}

GlOutcome draw_on_gl_thread(RenderWorld& world, const RenderSpec& spec, const Preparation& preparation,
                            const Views& views, const EarlierScene* earlier, int max_tile_px,
                            const Deadline& deadline) {
  GlOutcome outcome;
  gl::Context& context = world.context();
  world.programs().poll_sources(context);
  world.residency().begin_frame();

  const Clock::time_point upload_start = Clock::now();
  // The middle, then the moments.
  std::vector<GpuScene> scenes(1 + preparation.moments.size());
  std::vector<FrameSubject> subjects;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const PreparedScene& prepared = i == 0 ? preparation.scene : preparation.moments[i - 1].scene;
    const View& view = i == 0 ? views.middle : views.moments[i - 1];
    if (!make_gpu_scene(context, world.residency(), prepared, view, scenes[i])) {
      outcome.kind = GlOutcome::Kind::kEvicted;
      return outcome;
    }
    world.frames().provide_ground_shadow(world.residency(), prepared, scenes[i], deadline);
    subjects.push_back({view, scenes[i], prepared});
  }
  const std::span<const FrameSubject> moments = std::span(subjects).subspan(1);
  outcome.upload_ms = ms_since(upload_start);
  outcome.upload_hit = !world.residency().uploaded();

  const auto draw = [&](const FramePlan& plan) {
    FrameResult drawn =
        world.frames().render(world.residency(), plan, subjects.front(), moments, earlier, deadline);
    drawn.draw_ms += outcome.frame.draw_ms;
    drawn.readback_ms += outcome.frame.readback_ms;
    outcome.frame = std::move(drawn);
    return std::move(outcome.frame.pixels);
  };
  double auto_ev = 0;
  if (std::holds_alternative<AutoExposure>(spec.camera.metering))
    auto_ev = metered_ev(draw(plan_meter(spec, max_tile_px)));
  FramePlan plan = plan_frame(spec, max_tile_px, auto_ev);
  if (plan.bloom)
    plan.bloom->glow = spread_glow(draw(plan_glow(plan, max_tile_px)), *spec.output.bloom, plan.picture);
  outcome.frame.pixels = draw(plan);
  outcome.exposure_ev = plan.exposure_ev;
  if (context.lost()) outcome.kind = GlOutcome::Kind::kContextLost;
  return outcome;
}

Image drop_alpha(const Image& rgba) {
  Image rgb = make_image(rgba.extent, 3, rgba.type, rgba.color_space);
  const std::size_t bytes = sample_bytes(rgba.type);
  const std::byte* from = rgba.pixels.data();
  std::byte* to = rgb.pixels.data();
  for (std::int64_t i = 0; i < rgba.extent.area(); ++i, from += 4 * bytes, to += 3 * bytes) {
    std::copy_n(from, 3 * bytes, to);
  }
  return rgb;
}

// Film layers that are made of the visibility frame do not know all that is drawn.
bool misses_veil(const OutputSpec& output, const PreparedScene& scene) {
  const auto sees_through = [](FilmLayer layer) {
    const FilmLayerKind kind = row_of(layer).kind;
    return kind == FilmLayerKind::kPlace || kind == FilmLayerKind::kMatte;
  };
  const auto is_veil = [&](const Instance& instance) {
    const Material& material = scene.materials[std::size_t(instance.material)];
    const Mesh& mesh = *scene.meshes[std::size_t(instance.mesh)].mesh;
    return mesh.topology != Topology::kTriangles ||
           (material.alpha_mode == AlphaMode::kBlend && !(material.transmission > 0));
  };
  const bool wanted = (output.shown && sees_through(*output.shown)) ||
                      std::any_of(output.layers.begin(), output.layers.end(), sees_through);
  return wanted && std::any_of(scene.instances.begin(), scene.instances.end(), is_veil);
}

// Motion vectors use the shutter, too.
bool loses_motion_blur(const RenderSpec& spec) {
  return spec.output.samples == 1 && spec.camera.motion.shutter_s > 0 && moves(spec) &&
         !wants_motion(spec.output);
}

RenderSpec probe_spec() {
  RenderSpec spec;
  NodeSpec sphere;
  sphere.mesh = "sphere";
  spec.scene.nodes = {sphere};
  spec.environment.map = EnvironmentColor{};
  spec.output.width = spec.output.height = 16;
  spec.output.format = OutputFormat::kExr;
  spec.output.exr_type = SampleType::kFloat32;
  return spec;
}

// `count` contexts over the devices that "0,1" names, in turn; 0: one on each.
std::vector<std::string> devices_of(const std::string& list, int count) {
  std::vector<std::string> named;
  for (std::size_t from = 0; from <= list.size();) {
    const std::size_t comma = std::min(list.find(',', from), list.size());
    named.push_back(list.substr(from, comma - from));
    from = comma + 1;
  }
  std::vector<std::string> devices;
  const std::size_t wanted = count > 0 ? std::size_t(count) : named.size();
  for (std::size_t i = 0; i < wanted; ++i) devices.push_back(named[i % named.size()]);
  return devices;
}

// What a context keeps resident is chiefly of the scene; how it is looked at does not matter.
ContentHash affinity_of(const RenderSpec& spec) {
  RenderSpec scene_only;
  scene_only.scene = spec.scene;
  return spec_hash(scene_only);
}

}  // namespace

std::string Fingerprint::text() const {
  return fmt::format("{}; shaders {}; {}", build, shaders, gl);
}

struct Renderer::State {
  State(const RendererConfig& config, WorkerPool& pool, Decoder& decoder)
      : contexts({{config.gl, config.shader_dir, config.gpu_cache_bytes},
                  devices_of(config.gl.device, config.contexts),
                  config.context_life}),
        scenes(within(contexts.limits(), config), pool, decoder),
        max_tile_px(config.max_tile_px) {}

  Film render(const RenderSpec& spec, ContextPool::Lease& context, const Deadline& deadline,
              const TellStage& tell);

  void compare_probe(const ContentHash& pixels) {
    const std::lock_guard lock(probe_mutex);
    if (!first_probe) first_probe = pixels;
    if (pixels == *first_probe || !probes_are_alike) return;
    probes_are_alike = false;
    log::error("probe.differs", {{"first", first_probe->hex()}, {"now", pixels.hex()}});
  }

  static RendererConfig within(const gl::Limits& limits, RendererConfig config) {
    config.texture.max_side_px = std::min(config.texture.max_side_px, limits.max_texture_px);
    return config;
  }

  ContextPool contexts;
  SceneStore scenes;
  const int max_tile_px;
  Fingerprint fingerprint;
  std::mutex probe_mutex;
  std::optional<ContentHash> first_probe;  // of its pixels; belongs to the mutex
  std::atomic<bool> probes_are_alike = true;
};

Renderer::Renderer(const RendererConfig& config, WorkerPool& pool, Decoder& decoder)
    : state_(std::make_unique<State>(config, pool, decoder)) {
  state_->fingerprint.build = config.build_id;
  state_->fingerprint.gl = state_->contexts.description();
  state_->fingerprint.shaders = state_->contexts.shaders().hex().substr(0, 12);
}

Renderer::~Renderer() = default;

Film Renderer::render(const RenderSpec& spec, const Deadline& deadline, const TellStage& tell) {
  ContextPool::Lease context = state_->contexts.lease(affinity_of(spec));
  return state_->render(spec, context, deadline, tell);
}

Film Renderer::State::render(const RenderSpec& spec, ContextPool::Lease& context, const Deadline& deadline,
                             const TellStage& tell) {
  Film film;
  GlOutcome outcome;
  // Twice is rare (an eviction or a reset between two steps), more is a fault.
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    context.begin(deadline);
    Preparation preparation = scenes.prepare(spec, context.resident(), deadline, tell, film.times);
    if (tell) tell("draw", 0);
    Framing framing(spec, preparation);
    Views views{framing.middle(), {}};
    for (const PreparedMoment& moment : preparation.moments)
      views.moments.push_back(framing.at(moment.composed->scene, moment.offset_s));
    const double interval_s = spec.camera.motion.interval_s();
    std::shared_ptr<const ComposedScene> before;
    std::optional<EarlierScene> earlier;
    if (wants_motion(spec.output) && interval_s > 0) {
      before = scenes.composed(scene_at(spec.scene, -interval_s), deadline);
      earlier.emplace(EarlierScene{before->scene, framing.at(before->scene, -interval_s)});
    }
    const Clock::time_point asked = Clock::now();
    outcome = context.thread().call(deadline, [&](RenderWorld& world) {
      const double queue_ms = ms_since(asked);
      GlOutcome drawn = draw_on_gl_thread(world, spec, preparation, views, earlier ? &*earlier : nullptr,
                                          max_tile_px, deadline);
      drawn.queue_ms = queue_ms;
      return drawn;
    });
    film.notes = std::move(preparation.notes);
    if (spec.camera.depth_of_field && spec.output.samples == 1)
      film.notes.push_back({"depth-of-field-needs-samples", "/camera/depthOfField",
                            "a single sample sees through a pinhole; ask for quality high or for samples"});
    if (loses_motion_blur(spec))
      film.notes.push_back({"motion-blur-needs-samples", "/camera/motionBlur",
                            "a single sample sees one instant; ask for quality high or for samples"});
    if (wants_motion(spec.output) && interval_s == 0)
      film.notes.push_back({"motion-needs-interval", "/camera/motionBlur",
                            "without a shutter that is open for a while, or a sequence, motion is 0"});
    if (misses_veil(spec.output, preparation.scene))
      film.notes.push_back(
          {"layers-see-through", "/output",
           "what is blended, lines and points are not in depth, position, uv, ids and mattes"});
    film.times.queue_ms += outcome.queue_ms;
    film.times.upload_ms += outcome.upload_ms;
    if (outcome.kind == GlOutcome::Kind::kDone) break;
    if (attempt == kTries) fail(ErrorCode::kGpuUnavailable, "the GPU keeps losing this scene; try again");
    if (outcome.kind == GlOutcome::Kind::kContextLost) {
      log::warning("gl.lost", {{"attempt", attempt}});
      context.rebuild(deadline);
    }
  }
  film.exposure_ev = outcome.exposure_ev;
  film.times.upload_hit = outcome.upload_hit;
  film.times.draw_ms = outcome.frame.draw_ms;
  film.times.readback_ms = outcome.frame.readback_ms;
  const bool opaque = !std::holds_alternative<TransparentBackground>(spec.environment.background);
  const bool has_alpha = outcome.frame.pixels.channels == 4;
  film.image = opaque && has_alpha ? drop_alpha(outcome.frame.pixels) : std::move(outcome.frame.pixels);
  film.layers = std::move(outcome.frame.layers);
  film.attributes = std::move(outcome.frame.attributes);
  return film;
}

SceneOutline Renderer::outline(const RenderSpec& spec, const Deadline& deadline) {
  const Scene scene = state_->scenes.swept(spec, deadline);
  return {outline_of(scene, spec.camera), longest_clip_s(spec.scene, scene.animations)};
}

EnvironmentAnswer Renderer::environment(const EnvironmentSpec& spec, const Deadline& deadline) {
  return state_->scenes.environment_summary(spec, deadline);
}

bool Renderer::probe(const Deadline& deadline) {
  for (std::size_t i = 0; i < state_->contexts.size(); ++i) {
    ContextPool::Lease context = state_->contexts.lease(i);
    const Film film = state_->render(probe_spec(), context, deadline, {});
    // A white furnace: whatever is drawn, every pixel is 1.
    const auto right = [](float value) { return std::abs(value - 1) <= 5e-3f; };
    const auto pixels = film.image.samples<float>();
    state_->compare_probe(hash_bytes(film.image.pixels));
    if (!std::all_of(pixels.begin(), pixels.end(), right)) return false;
  }
  return true;
}

std::chrono::milliseconds Renderer::overdue() const {
  return std::chrono::duration_cast<std::chrono::milliseconds>(state_->contexts.overdue());
}

const Fingerprint& Renderer::fingerprint() const {
  return state_->fingerprint;
}
const gl::Limits& Renderer::limits() const {
  return state_->contexts.limits();
}
RendererStats Renderer::stats() const {
  return {state_->contexts.stats(), state_->scenes.baked_stats(), state_->probes_are_alike};
}

}  // namespace furnace
