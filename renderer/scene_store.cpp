#include "renderer/scene_store.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include "renderer/base/error.hpp"
#include "renderer/base/stopwatch.hpp"
#include "renderer/frame/sky_plan.hpp"
#include "renderer/ibl/light_cells.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/model_errors.hpp"
#include "renderer/scene/model_import.hpp"
#include "renderer/scene/occluder.hpp"
#include "renderer/scene/shutter.hpp"
#include "renderer/prepare.hpp"
#include "renderer/prepare_ground.hpp"

namespace furnace {
namespace {

ColorSpace texture_color_space(const Material& material, std::size_t use) {
  return is_color_texture(material, TextureUse(use)) ? ColorSpace::kSrgb : ColorSpace::kNonColor;
}

constexpr std::size_t kMostSuns = 4;

// The scene's own, as many as the shaders take, and the suns of the environment; those that give nothing are left out. Returns
// how many were too many.
std::size_t take_lights(const std::vector<Light>& lights, double rotation_rad, PreparedScene& out) {
  std::size_t left_out = 0;
  for (const Light& light : lights) {
    if (light.intensity == glm::dvec3(0)) continue;
    if (out.lights.size() + kMostSuns < gpu::MOST_LIGHTS) {
      out.lights.push_back(light);
    } else {
      ++left_out;
    }
  }
  if (!out.environment->summary.suns_extracted) return left_out;
  const glm::dmat3 world_from_environment = turned_about_y(rotation_rad);
  for (const Sun& sun : out.environment->summary.suns) {
    Light light;
    light.kind = LightKind::kDirectional;
    light.direction = -(world_from_environment * vector_of(sun.direction));
    light.intensity = vector_of(sun.irradiance) * out.environment_intensity;
    light.angular_radius_rad = sun.angular_radius_rad;
    out.lights.push_back(light);
  }
  return left_out;
}

void note_lights_left_out(std::size_t count, std::vector<Note>& notes) {
  if (count == 0) return;
  notes.push_back({"lights-left-out", "/extensions/KHR_lights_punctual/lights",
                   fmt::format("{} lights more than are drawn at once ({}) were left out", count,
                               gpu::MOST_LIGHTS - kMostSuns)});
}

ImportOptions import_options(const SceneSpec& spec) {
  return {spec.gltf_scene, spec.variant, spec.animations};
}

ContentHash scene_hash(const SceneSpec& spec) {
  RenderSpec scene_only;
  scene_only.scene = spec;
  return spec_hash(scene_only);
}

// The middle, then the moments.
std::vector<PreparedScene*> scenes_of(Preparation& out) {
  std::vector<PreparedScene*> scenes = {&out.scene};
  for (PreparedMoment& moment : out.moments) scenes.push_back(&moment.scene);
  return scenes;
}

std::vector<const ComposedScene*> composed_of(const Preparation& out) {
  std::vector<const ComposedScene*> composed = {out.composed.get()};
  for (const PreparedMoment& moment : out.moments) composed.push_back(moment.composed.get());
  return composed;
}

// Of all instances.
std::size_t triangle_count(const Scene& scene) {
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[std::size_t(instance.mesh)];
    if (mesh.topology == Topology::kTriangles) count += mesh.indices.size() / 3;
  }
  return count;
}

}  // namespace

SceneStore::SceneStore(const RendererConfig& config, WorkerPool& pool, Decoder& decoder)
    : config_(config),
      pool_(pool),
      decoder_(decoder),
      imports_(config.scene_cache_bytes, [](const Scene& scene) { return std::int64_t(scene.byte_size()); }),
      compositions_(config.scene_cache_bytes,
                    [](const ComposedScene& scene) { return std::int64_t(scene.byte_size()); }),
      moments_(config.scene_cache_bytes,
               [](const ComposedMoments& moments) { return std::int64_t(moments.byte_size()); }),
      environments_(config, pool, decoder) {}

std::shared_ptr<const Scene> SceneStore::imported(const SceneSpec& spec, const Deadline& deadline) {
  HashBuilder key;
  key.add(spec.model->hash).add(std::int64_t(spec.gltf_scene));
  if (spec.variant) key.add(*spec.variant);
  if (spec.up_axis) key.add("up").add(std::int64_t(*spec.up_axis));
  RenderSpec animated;
  animated.scene.animations = spec.animations;
  key.add(spec_hash(animated));
  return imports_.get_or_load(key.finish(), deadline, [&] {
    return import_for("/scene/model", [&] {
      if (spec.model->format != ModelFormat::kGltf)
        return import_model(*spec.model, spec.up_axis, config_.import, decoder_, deadline);
      return import_gltf(decoder_, *spec.model, import_options(spec), config_.import, deadline);
    });
  });
}

std::shared_ptr<const ComposedScene> SceneStore::compose(const SceneSpec& spec, const Deadline& deadline,
                                                         bool& hit) {
  CacheOutcome outcome = CacheOutcome::kLoaded;
  auto composed = compositions_.get_or_load(
      scene_hash(spec), deadline,
      [&] { return compose_scene(spec, spec.model == nullptr ? nullptr : imported(spec, deadline).get()); },
      &outcome);
  hit = outcome == CacheOutcome::kHit;
  return composed;
}

std::shared_ptr<const ComposedMoments> SceneStore::composed_moments(const RenderSpec& spec,
                                                                    const ComposedScene& middle,
                                                                    const Deadline& deadline, bool& hit) {
  const Shutter shutter{spec.output.samples, moments_wanted(spec), spec.camera.motion.shutter_s};
  const ContentHash key = HashBuilder()
                              .add("moments")
                              .add(scene_hash(spec.scene))
                              .add(std::int64_t(shutter.subframes))
                              .add(shutter.open_s)
                              .finish();
  CacheOutcome outcome = CacheOutcome::kLoaded;
  const auto load = [&] {
    const SceneSpec& scene = spec.scene;
    if (scene.model == nullptr || scene.model->format != ModelFormat::kGltf) {
      const auto model = scene.model == nullptr ? nullptr : imported(scene, deadline);
      return compose_moments(scene, middle, shutter, kMostMomentBytes,
                             [&](const std::vector<AnimationClip>&) { return model; });
    }
    return import_for("/scene/model", [&] {
      GltfModel model(decoder_, *scene.model, config_.import, deadline, GltfModel::Times::kSeveral);
      return compose_moments(scene, middle, shutter, kMostMomentBytes,
                             [&](const std::vector<AnimationClip>& clips) {
                               ImportOptions options = import_options(scene);
                               options.animations = clips;
                               return std::make_shared<const Scene>(model.import(options));
                             });
    });
  };
  auto moments = moments_.get_or_load(key, deadline, load, &outcome);
  hit = hit && outcome == CacheOutcome::kHit;
  return moments;
}

std::shared_ptr<const ComposedScene> SceneStore::composed(const SceneSpec& spec, const Deadline& deadline) {
  bool hit = false;
  return compose(spec, deadline, hit);
}

Scene SceneStore::swept(const RenderSpec& spec, const Deadline& deadline) {
  const auto middle = composed(spec.scene, deadline);
  if (moments_wanted(spec) == 0) return middle->scene;
  bool hit = false;
  const auto moments = composed_moments(spec, *middle, deadline, hit);
  std::vector<const Scene*> scenes;
  for (const auto& moment : moments->scenes) scenes.push_back(&moment->scene);
  return swept_scene(middle->scene, scenes);
}

void SceneStore::add_moments(const RenderSpec& spec, const Deadline& deadline, bool& hit, Preparation& out) {
  const int wanted = moments_wanted(spec);
  if (wanted == 0) return;
  const auto moments = composed_moments(spec, *out.composed, deadline, hit);
  for (std::size_t i = 0; i < moments->scenes.size(); ++i)
    out.moments.push_back({moments->scenes[i], moments->offsets_s[i], {}});
  if (const auto seen = moments->scenes.size(); seen < std::size_t(wanted))
    out.notes.push_back({"motion-blur-coarse", "/camera/motionBlur",
                         fmt::format("the scene at one moment takes so much memory that the open shutter is "
                                     "seen at {} moments, not {}",
                                     seen, wanted)});
}

std::vector<PreparedMesh> SceneStore::prepare_meshes(const ResidentKeys& resident, const Preparation& out) {
  std::vector<PreparedMesh> meshes;
  std::set<ContentHash> known;
  for (const ComposedScene* composed : composed_of(out)) {
    for (const SharedMesh& mesh : composed->scene.meshes)
      if (known.insert(mesh->key).second) meshes.push_back({mesh->key, mesh, nullptr, nullptr});
  }
  constexpr double kPackCostUs = 1'000;
  pool_.parallel_for(meshes.size(), kPackCostUs, [&](std::size_t i) {
    if (!resident.contains(meshes[i].key))
      meshes[i].packed = std::make_shared<const PackedMesh>(pack_mesh(*meshes[i].mesh));
  });
  return meshes;
}

void SceneStore::prepare_occluders(const ResidentKeys& resident, std::vector<PreparedMesh>& meshes) {
  constexpr double kSimplifyCostUs = 5'000;
  pool_.parallel_for(meshes.size(), kSimplifyCostUs, [&](std::size_t i) {
    PreparedMesh& mesh = meshes[i];
    if (mesh.mesh->topology != Topology::kTriangles || resident.contains(occluder_key_of(mesh.key))) return;
    mesh.occluder =
        std::make_shared<const std::vector<std::uint32_t>>(occluder_indices(*mesh.mesh, kSurfaceOccluder));
  });
}

void SceneStore::prepare_textures(const ResidentKeys& resident, const Deadline& deadline, bool& hit,
                                  Preparation& out) {
  struct Wanted {
    const SceneImage* image;
    ColorSpace color_space;
  };
  std::vector<Wanted> wanted;
  std::map<std::tuple<ContentHash, std::string, ColorSpace>, int> index_of;
  const std::vector<PreparedScene*> scenes = scenes_of(out);
  const std::vector<const ComposedScene*> composed = composed_of(out);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    for (Material& material : scenes[i]->materials) {
      for (std::size_t use = 0; use < kTextureUses; ++use) {
        auto& slot = material.textures[use];
        if (!slot) continue;
        const SceneImage& image = composed[i]->scene.images[std::size_t(slot->image)];
        const ColorSpace color_space = texture_color_space(material, use);
        const auto [entry, fresh] =
            index_of.try_emplace({image.encoded.hash(), image.pointer, color_space}, int(wanted.size()));
        if (fresh) wanted.push_back({&image, color_space});
        slot->image = entry->second;
      }
    }
  }
  std::vector<PreparedTexture> textures(wanted.size());
  std::vector<std::vector<Note>> texture_notes(wanted.size());
  constexpr double kDecodeCostUs = 10'000;
  pool_.parallel_for(wanted.size(), kDecodeCostUs, [&](std::size_t i) {
    const Wanted& texture = wanted[i];
    textures[i].key = HashBuilder()
                          .add("texture")
                          .add(texture.image->encoded.hash())
                          .add(std::int64_t(texture.color_space))
                          .finish();
    if (resident.contains(textures[i].key)) {
      texture_notes[i] = texture_notes_.recall(textures[i].key, texture.image->pointer);
      return;
    }
    PreparedPixels prepared = prepare_texture(decoder_, texture.image->encoded, texture.color_space,
                                              texture.image->pointer, config_.texture, deadline);
    textures[i].levels = std::make_shared<const std::vector<Image>>(std::move(prepared.levels));
    textures[i].lowest_green = prepared.lowest_green;
    texture_notes_.remember(textures[i].key, prepared.notes);
    texture_notes[i] = std::move(prepared.notes);
  });
  for (auto& more : texture_notes) std::move(more.begin(), more.end(), std::back_inserter(out.notes));
  for (const PreparedTexture& texture : textures) hit = hit && texture.levels == nullptr;
  for (PreparedScene* scene : scenes) scene->textures = textures;
}

EnvironmentAnswer SceneStore::environment_summary(const EnvironmentSpec& spec, const Deadline& deadline) {
  StageTimes times;
  const auto found = environments_.baked(spec.map, spec.sun, deadline, {}, times);
  return {found->environment.summary, times.bake_hit};
}

void SceneStore::prepare_environment(const RenderSpec& spec, const Deadline& deadline, const TellStage& tell,
                                     StageTimes& times, Preparation& out) {
  const EnvironmentSpec& wanted = spec.environment;
  const auto baked = environments_.baked(wanted.map, wanted.sun, deadline, tell, times);
  out.notes.insert(out.notes.end(), baked->notes.begin(), baked->notes.end());
  const PreparedEnvironment& environment = baked->environment;
  PreparedScene& scene = out.scene;
  scene.environment = std::shared_ptr<const PreparedEnvironment>(baked, &environment);
  scene.environment_intensity = wanted.intensity;
  if (wanted.illuminance_lux) {
    const double lux = environment.summary.horizontal_illuminance_lux;
    if (!(lux > 0)) {
      fail(ErrorCode::kUnprocessable,
           "the environment lets no light fall on a horizontal plane, so nothing scales it to an illuminance",
           "/environment/illuminanceLux");
    }
    scene.environment_intensity *= *wanted.illuminance_lux / lux;
  }

  if (const auto* seen = std::get_if<EnvironmentBackground>(&wanted.background)) {
    scene.background_intensity = seen->intensity;
    if (!seen->map) scene.background_intensity *= scene.environment_intensity;
    if (!seen->map && seen->blur_rad == 0) {
      scene.background = std::shared_ptr<const PreparedSky>(baked, &environment.seen());
    } else {
      const auto background =
          environments_.background(seen->map.value_or(wanted.map), seen->blur_rad, deadline, times);
      scene.background = std::shared_ptr<const PreparedSky>(background, &background->sky);
      // Those of the environment's own map were told.
      if (seen->map) out.notes.insert(out.notes.end(), background->notes.begin(), background->notes.end());
    }
  }
  if (sky_is_shadowed(spec)) {
    const int views = sky_views_wanted(spec.output.samples, triangle_count(out.composed->scene));
    scene.sky_lights = in_world(light_cells(scene.environment->sky.texels, views * spec.output.samples),
                                scene, wanted.rotation_rad);
    if (!scene.sky_lights.empty())
      scene.sky_sums = light_sums(scene.sky_lights, gpu::SKY_SUMS_PX, gpu::SKY_LOBES, pool_);
  }
  // What lights the middle lights every moment; the sums are read once.
  for (PreparedMoment& moment : out.moments) {
    moment.scene.environment = scene.environment;
    moment.scene.background = scene.background;
    moment.scene.sky_lights = scene.sky_lights;
    moment.scene.environment_intensity = scene.environment_intensity;
    moment.scene.background_intensity = scene.background_intensity;
  }
}

void SceneStore::prepare_grounds(const RenderSpec& spec, const ResidentKeys& resident, StageTimes& times,
                                 Preparation& out) {
  if (!spec.environment.ground) return;
  const Stopwatch watch(times.bake_ms);
  GroundWork work(*spec.environment.ground, spec.environment.rotation_rad, spec.output.samples, resident,
                  pool_);
  const std::vector<PreparedScene*> scenes = scenes_of(out);
  for (const PreparedScene* scene : scenes) work.add_bounds(scene->bounds);
  const bool metered = std::holds_alternative<AutoExposure>(spec.camera.metering);
  out.scene.ground = out.moments.empty() || metered ? work.with_shadow(scene_hash(spec.scene), out.scene, {})
                                                    : work.without_shadow();
  for (std::size_t i = 0; i < out.moments.size(); ++i) {
    PreparedMoment& moment = out.moments[i];
    moment.scene.ground = work.with_shadow(scene_hash(scene_at(spec.scene, moment.offset_s)), moment.scene,
                                           {int(i), int(out.moments.size())});
  }
}

Preparation SceneStore::prepare(const RenderSpec& spec, const ResidentKeys& resident,
                                const Deadline& deadline, const TellStage& tell, StageTimes& times) {
  Preparation out;
  std::vector<PreparedMesh> meshes;
  {
    const Stopwatch watch(times.decode_ms);
    out.composed = compose(spec.scene, deadline, times.decode_hit);
    out.notes = out.composed->scene.notes;
    add_moments(spec, deadline, times.decode_hit, out);
    const std::vector<PreparedScene*> scenes = scenes_of(out);
    const std::vector<const ComposedScene*> composed = composed_of(out);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      scenes[i]->materials = composed[i]->scene.materials;
      scenes[i]->instances = composed[i]->scene.instances;
      scenes[i]->bounds = composed[i]->bounds;
    }
    meshes = prepare_meshes(resident, out);
    check_deadline(deadline, "decode");
    prepare_textures(resident, deadline, times.decode_hit, out);
  }
  check_deadline(deadline, "bake");
  prepare_environment(spec, deadline, tell, times, out);
  if (!out.scene.sky_lights.empty()) prepare_occluders(resident, meshes);
  std::map<ContentHash, const PreparedMesh*> mesh_of;
  for (const PreparedMesh& mesh : meshes) mesh_of.emplace(mesh.key, &mesh);
  std::size_t lights_left_out = 0;
  const std::vector<PreparedScene*> scenes = scenes_of(out);
  const std::vector<const ComposedScene*> composed = composed_of(out);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    for (const SharedMesh& mesh : composed[i]->scene.meshes)
      scenes[i]->meshes.push_back(*mesh_of.at(mesh->key));
    const std::size_t left_out =
        take_lights(composed[i]->scene.lights, spec.environment.rotation_rad, *scenes[i]);
    lights_left_out = std::max(lights_left_out, left_out);
  }
  note_lights_left_out(lights_left_out, out.notes);
  prepare_grounds(spec, resident, times, out);
  return out;
}

}  // namespace furnace
