#include "renderer/scene_store.hpp"

#include <algorithm>
#include <iterator>
#include <map>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/base/error.hpp"
#include "renderer/base/stopwatch.hpp"
#include "renderer/frame/sky_plan.hpp"
#include "renderer/ibl/light_cells.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/model_errors.hpp"
#include "renderer/scene/model_import.hpp"
#include "renderer/scene/occluder.hpp"
#include "renderer/prepare.hpp"

namespace furnace {
namespace {

ColorSpace texture_color_space(const Material& material, std::size_t use) {
  return is_color_texture(material, TextureUse(use)) ? ColorSpace::kSrgb : ColorSpace::kNonColor;
}

glm::dvec3 vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

glm::dmat3 turned_about_y(double angle_rad) {
  return glm::dmat3(glm::rotate(glm::dmat4(1), angle_rad, glm::dvec3(0, 1, 0)));
}

// As many as the shaders take, the suns aside; those that give nothing are left out.
void take_lights(Preparation& out) {
  constexpr std::size_t kMostSuns = 4;
  std::size_t left_out = 0;
  for (const Light& light : out.composed->scene.lights) {
    if (light.intensity == glm::dvec3(0)) continue;
    if (out.scene.lights.size() + kMostSuns < gpu::MOST_LIGHTS) {
      out.scene.lights.push_back(light);
    } else {
      ++left_out;
    }
  }
  if (left_out == 0) return;
  out.notes.push_back({"lights-left-out", "/extensions/KHR_lights_punctual/lights",
                       fmt::format("{} lights more than are drawn at once ({}) were left out", left_out,
                                   gpu::MOST_LIGHTS - kMostSuns)});
}

// Directions that stand for the environment, as it shines in the scene.
std::vector<LightDirection> in_world(std::vector<LightDirection> sources, const PreparedScene& scene,
                                     double rotation_rad) {
  const glm::dmat3 world_from_environment = turned_about_y(rotation_rad);
  for (LightDirection& source : sources) {
    const glm::dvec3 turned = world_from_environment * vector_of(source.towards);
    source.towards = {turned.x, turned.y, turned.z};
    for (double& share : source.irradiance)
      share *= scene.environment_intensity / scene.environment->sky.scale;
  }
  return sources;
}

// Of all instances.
std::size_t triangle_count(const PreparedScene& scene) {
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[std::size_t(instance.mesh)].mesh;
    if (mesh.topology == Topology::kTriangles) count += mesh.indices.size() / 3;
  }
  return count;
}

// The environment's light and that of directional lights, in world space: about `count` directions.
std::vector<LightDirection> light_on_ground(const PreparedScene& scene, double rotation_rad, int count) {
  std::vector<LightDirection> sources =
      in_world(ground_light(scene.environment->sky.texels, count), scene, rotation_rad);
  std::vector<std::vector<LightDirection>> all = {std::move(sources)};
  for (const Light& light : scene.lights) {
    if (light.kind != LightKind::kDirectional || !light.casts_shadow) continue;
    const glm::dvec3 &d = light.direction, &e = light.intensity;
    all.push_back(ground_light({-d.x, -d.y, -d.z}, {e.x, e.y, e.z}, light.angular_radius_rad, count));
  }
  return joined_by_light(std::move(all), count);
}

}  // namespace

SceneStore::SceneStore(const RendererConfig& config, WorkerPool& pool, Decoder& decoder)
    : config_(config),
      pool_(pool),
      decoder_(decoder),
      imports_(config.scene_cache_bytes, [](const Scene& scene) { return std::int64_t(scene.byte_size()); }),
      compositions_(config.scene_cache_bytes,
                    [](const ComposedScene& scene) { return std::int64_t(scene.byte_size()); }),
      environments_(config, pool, decoder) {}

std::shared_ptr<const ComposedScene> SceneStore::compose(const SceneSpec& spec, const Deadline& deadline,
                                                         bool& hit) {
  RenderSpec scene_only;
  scene_only.scene = spec;
  CacheOutcome outcome = CacheOutcome::kLoaded;
  auto composed = compositions_.get_or_load(
      spec_hash(scene_only), deadline,
      [&] {
        if (spec.model == nullptr) return compose_scene(spec, nullptr);
        HashBuilder key;
        key.add(spec.model->hash).add(std::int64_t(spec.gltf_scene));
        if (spec.variant) key.add(*spec.variant);
        if (spec.up_axis) key.add("up").add(std::int64_t(*spec.up_axis));
        RenderSpec animated;
        animated.scene.animations = spec.animations;
        key.add(spec_hash(animated));
        const auto model = imports_.get_or_load(key.finish(), deadline, [&] {
          return import_for("/scene/model", [&] {
            if (spec.model->format != ModelFormat::kGltf)
              return import_model(*spec.model, spec.up_axis, config_.import, decoder_, deadline);
            return import_gltf(decoder_, *spec.model,
                               ImportOptions{spec.gltf_scene, spec.variant, spec.animations}, config_.import,
                               deadline);
          });
        });
        return compose_scene(spec, model.get());
      },
      &outcome);
  hit = outcome == CacheOutcome::kHit;
  return composed;
}

std::shared_ptr<const ComposedScene> SceneStore::composed(const SceneSpec& spec, const Deadline& deadline) {
  bool hit = false;
  return compose(spec, deadline, hit);
}

void SceneStore::prepare_meshes(const ResidentKeys& resident, Preparation& out) {
  const std::vector<Mesh>& meshes = out.composed->scene.meshes;
  out.scene.meshes.resize(meshes.size());
  constexpr double kPackCostUs = 1'000;
  pool_.parallel_for(meshes.size(), kPackCostUs, [&](std::size_t i) {
    PreparedMesh& prepared = out.scene.meshes[i];
    prepared.key = meshes[i].key;
    // Shares the composition's life: the mesh is not copied.
    prepared.mesh = std::shared_ptr<const Mesh>(out.composed, &meshes[i]);
    if (!resident.contains(prepared.key))
      prepared.packed = std::make_shared<const PackedMesh>(pack_mesh(meshes[i]));
  });
}

void SceneStore::prepare_occluders(const ResidentKeys& resident, PreparedScene& out) {
  constexpr double kSimplifyCostUs = 5'000;
  pool_.parallel_for(out.meshes.size(), kSimplifyCostUs, [&](std::size_t i) {
    PreparedMesh& mesh = out.meshes[i];
    if (mesh.mesh->topology != Topology::kTriangles || resident.contains(occluder_key_of(mesh.key))) return;
    mesh.occluder =
        std::make_shared<const std::vector<std::uint32_t>>(occluder_indices(*mesh.mesh, kSurfaceOccluder));
  });
}

void SceneStore::prepare_textures(const ResidentKeys& resident, PreparedScene& out, const Scene& scene,
                                  const Deadline& deadline, std::vector<Note>& notes, bool& hit) {
  struct Wanted {
    const SceneImage* image;
    ColorSpace color_space;
  };
  std::vector<Wanted> wanted;
  std::map<std::pair<int, ColorSpace>, int> index_of;
  for (Material& material : out.materials) {
    for (std::size_t use = 0; use < kTextureUses; ++use) {
      auto& slot = material.textures[use];
      if (!slot) continue;
      const ColorSpace color_space = texture_color_space(material, use);
      const auto [entry, fresh] = index_of.try_emplace({slot->image, color_space}, int(wanted.size()));
      if (fresh) wanted.push_back({&scene.images[std::size_t(slot->image)], color_space});
      slot->image = entry->second;
    }
  }
  out.textures.resize(wanted.size());
  std::vector<std::vector<Note>> texture_notes(wanted.size());
  constexpr double kDecodeCostUs = 10'000;
  pool_.parallel_for(wanted.size(), kDecodeCostUs, [&](std::size_t i) {
    const Wanted& texture = wanted[i];
    out.textures[i].key = HashBuilder()
                              .add("texture")
                              .add(texture.image->encoded.hash())
                              .add(std::int64_t(texture.color_space))
                              .finish();
    if (resident.contains(out.textures[i].key)) {
      texture_notes[i] = texture_notes_.recall(out.textures[i].key, texture.image->pointer);
      return;
    }
    PreparedPixels prepared = prepare_texture(decoder_, texture.image->encoded, texture.color_space,
                                              texture.image->pointer, config_.texture, deadline);
    out.textures[i].levels = std::make_shared<const std::vector<Image>>(std::move(prepared.levels));
    out.textures[i].lowest_green = prepared.lowest_green;
    texture_notes_.remember(out.textures[i].key, prepared.notes);
    texture_notes[i] = std::move(prepared.notes);
  });
  for (auto& more : texture_notes) std::move(more.begin(), more.end(), std::back_inserter(notes));
  for (const PreparedTexture& texture : out.textures) hit = hit && texture.levels == nullptr;
}

EnvironmentAnswer SceneStore::environment_summary(const EnvironmentSpec& spec, const Deadline& deadline) {
  StageTimes times;
  const auto found = environments_.baked(spec.map, spec.sun, deadline, times);
  return {found->environment.summary, times.bake_hit};
}

void SceneStore::prepare_environment(const RenderSpec& spec, const ResidentKeys& resident,
                                     const Deadline& deadline, StageTimes& times, Preparation& out) {
  const EnvironmentSpec& wanted = spec.environment;
  const auto baked = environments_.baked(wanted.map, wanted.sun, deadline, times);
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

  take_lights(out);
  if (environment.summary.suns_extracted) {
    const glm::dmat3 world_from_environment = turned_about_y(wanted.rotation_rad);
    for (const Sun& sun : environment.summary.suns) {
      Light light;
      light.kind = LightKind::kDirectional;
      light.direction = -(world_from_environment * vector_of(sun.direction));
      light.intensity = vector_of(sun.irradiance) * scene.environment_intensity;
      light.angular_radius_rad = sun.angular_radius_rad;
      scene.lights.push_back(light);
    }
  }
  if (const auto* seen = std::get_if<EnvironmentBackground>(&wanted.background)) {
    scene.background_intensity = seen->intensity;
    if (!seen->map) scene.background_intensity *= scene.environment_intensity;
    if (!seen->map && seen->blur_rad == 0) {
      scene.background = std::shared_ptr<const PreparedSky>(baked, &environment.seen());
    } else {
      scene.background =
          environments_.background(seen->map.value_or(wanted.map), seen->blur_rad, deadline, times);
    }
  }
  if (sky_is_shadowed(spec)) {
    const int views = sky_views_wanted(spec.output.samples, triangle_count(scene));
    scene.sky_lights = in_world(light_cells(scene.environment->sky.texels, views * spec.output.samples),
                                scene, wanted.rotation_rad);
    if (!scene.sky_lights.empty())
      scene.sky_sums = light_sums(scene.sky_lights, gpu::SKY_SUMS_PX, gpu::SKY_LOBES, pool_);
    prepare_occluders(resident, out.scene);
  }
  if (wanted.ground) prepare_ground(spec, resident, times, out);
}

void SceneStore::prepare_ground(const RenderSpec& spec, const ResidentKeys& resident, StageTimes& times,
                                Preparation& out) {
  const Stopwatch watch(times.bake_ms);
  const GroundSpec& wanted = *spec.environment.ground;
  PreparedGround ground;
  ground.bounds = out.scene.bounds;
  if (ground.bounds.empty()) ground.bounds = {glm::vec3(-0.5f), glm::vec3(0.5f)};  // as it is framed
  ground.level_m = wanted.level_m.value_or(double(ground.bounds.min.y));
  if (wanted.shadow) {
    // Sub-frames of finer pictures are worth finer penumbrae.
    const int lights = std::clamp(128 * spec.output.samples / 4, 128, 1024);
    const double rotation_rad = spec.environment.rotation_rad;
    RenderSpec scene_only;
    scene_only.scene = spec.scene;
    const ContentHash key = HashBuilder()
                                .add("ground")
                                .add(spec_hash(scene_only))
                                .add(out.scene.environment->key)
                                .add(rotation_rad)
                                .add(out.scene.environment_intensity)  // against the scene's own lights
                                .add(ground.level_m)
                                .add(std::int64_t(lights))
                                .finish();
    ground.shadow_key = key;
    if (!resident.contains(key)) {
      ground.light = std::make_shared<const std::vector<LightDirection>>(
          light_on_ground(out.scene, rotation_rad, lights));
      for (const Light& light : out.scene.lights) {
        if (light.kind == LightKind::kDirectional && !light.casts_shadow)
          ground.free_irradiance += light.intensity * std::max(-light.direction.y, 0.0);
      }
      const std::vector<Mesh>& meshes = out.composed->scene.meshes;
      ground.occluders.resize(meshes.size());
      constexpr double kSimplifyCostUs = 5'000;
      pool_.parallel_for(meshes.size(), kSimplifyCostUs, [&](std::size_t i) {
        if (meshes[i].topology == Topology::kTriangles)
          ground.occluders[i] = occluder_indices(meshes[i], kGroundOccluder);
      });
    }
  }
  out.scene.ground = std::move(ground);
}

Preparation SceneStore::prepare(const RenderSpec& spec, const ResidentKeys& resident,
                                const Deadline& deadline, StageTimes& times) {
  Preparation out;
  {
    const Stopwatch watch(times.decode_ms);
    out.composed = compose(spec.scene, deadline, times.decode_hit);
    const Scene& scene = out.composed->scene;
    out.notes = scene.notes;
    out.scene.materials = scene.materials;
    out.scene.instances = scene.instances;
    out.scene.bounds = out.composed->bounds;
    prepare_meshes(resident, out);
    check_deadline(deadline, "decode");
    prepare_textures(resident, out.scene, scene, deadline, out.notes, times.decode_hit);
  }
  check_deadline(deadline, "bake");
  prepare_environment(spec, resident, deadline, times, out);
  return out;
}

}  // namespace furnace
