#include "renderer/scene_store.hpp"

#include <chrono>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/prepare.hpp"

namespace furnace {
namespace {

class Stopwatch {
 public:
  explicit Stopwatch(double& total_ms) : total_ms_(total_ms) {}
  ~Stopwatch() { total_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_ms_;
  Clock::time_point start_ = Clock::now();
};

ColorSpace slot_color_space(gpu::Slot slot) {
  return slot == gpu::kBaseColor || slot == gpu::kEmissive ? ColorSpace::kSrgb : ColorSpace::kNonColor;
}

ContentHash environment_key(const EnvironmentSpec& spec) {
  HashBuilder key;
  key.add("environment").add(std::int64_t(kBakeVersion));
  if (const auto* builtin = std::get_if<BuiltinName>(&spec.map)) {
    key.add("builtin").add(builtin->name);
  } else if (const auto* file = std::get_if<EnvironmentFile>(&spec.map)) {
    key.add("file").add(file->bytes.hash());
  } else if (const auto* procedural = std::get_if<ProceduralEnvironment>(&spec.map)) {
    key.add("procedural").add(procedural_hash(*procedural));
  } else {
    const glm::vec3 radiance = std::get<EnvironmentColor>(spec.map).radiance;
    key.add("color").add(double(radiance.r)).add(double(radiance.g)).add(double(radiance.b));
  }
  return key.finish();
}

std::vector<Note> repair_notes(const RepairReport& repairs) {
  const std::int64_t count = repairs.nan_samples + repairs.infinite_samples + repairs.negative_samples;
  if (count == 0) return {};
  return {{"environment-repaired", "/environment/map",
           fmt::format("the environment had {} NaN, {} infinite and {} negative samples, which were replaced",
                       repairs.nan_samples, repairs.infinite_samples, repairs.negative_samples)}};
}

}  // namespace

SceneStore::SceneStore(const RendererConfig& config, WorkerPool& pool, std::shared_ptr<ResidentKeys> resident)
    : config_(config),
      pool_(pool),
      resident_(std::move(resident)),
      imports_(config.scene_cache_bytes, [](const Scene& scene) { return std::int64_t(scene.byte_size()); }),
      compositions_(config.scene_cache_bytes,
                    [](const ComposedScene& scene) { return std::int64_t(scene.byte_size()); }),
      environments_(config.bake_cache_bytes,
                    [](const StoredBake& bake) { return std::int64_t(bake.environment.byte_size()); }),
      bake_store_(config.data_folder.empty()
                      ? nullptr
                      : std::make_unique<BakeStore>(config.data_folder, config.disk_cache_bytes)) {}

std::shared_ptr<const ComposedScene> SceneStore::compose(const SceneSpec& spec, const Deadline& deadline,
                                                         bool& hit) {
  RenderSpec scene_only;
  scene_only.scene = spec;
  CacheOutcome outcome = CacheOutcome::kLoaded;
  auto composed = compositions_.get_or_load(
      spec_hash(scene_only), deadline,
      [&] {
        if (spec.model == nullptr) return compose_scene(spec, nullptr);
        const ContentHash key =
            HashBuilder().add(spec.model->hash).add(std::int64_t(spec.gltf_scene)).finish();
        const auto model = imports_.get_or_load(key, deadline, [&] {
          return with_context("/scene/model", [&] {
            return import_gltf(*spec.model, ImportOptions{spec.gltf_scene}, config_.import, deadline);
          });
        });
        return compose_scene(spec, model.get());
      },
      &outcome);
  hit = outcome == CacheOutcome::kHit;
  return composed;
}

void SceneStore::prepare_meshes(Preparation& out) {
  const std::vector<Mesh>& meshes = out.composed->scene.meshes;
  out.scene.meshes.resize(meshes.size());
  constexpr double kPackCostUs = 1'000;
  pool_.parallel_for(meshes.size(), kPackCostUs, [&](std::size_t i) {
    PreparedMesh& prepared = out.scene.meshes[i];
    prepared.key = out.composed->mesh_keys[i];
    // Shares the composition's life: the mesh is not copied.
    prepared.mesh = std::shared_ptr<const Mesh>(out.composed, &meshes[i]);
    if (!resident_->contains(prepared.key))
      prepared.packed = std::make_shared<const PackedMesh>(pack_mesh(meshes[i]));
  });
}

void SceneStore::prepare_textures(PreparedScene& out, const Scene& scene, std::vector<Note>& notes,
                                  bool& hit) {
  struct Wanted {
    const SceneImage* image;
    ColorSpace color_space;
  };
  std::vector<Wanted> wanted;
  std::map<std::pair<int, ColorSpace>, int> index_of;
  for (Material& material : out.materials) {
    for (int i = 0; i < gpu::kSlotCount; ++i) {
      auto& slot = material.*gpu::kMaterialSlots[i];
      if (!slot) continue;
      const auto [entry, fresh] =
          index_of.try_emplace({slot->image, slot_color_space(gpu::Slot(i))}, int(wanted.size()));
      if (fresh) wanted.push_back({&scene.images[std::size_t(slot->image)], slot_color_space(gpu::Slot(i))});
      slot->image = entry->second;
    }
  }
  out.textures.resize(wanted.size());
  std::vector<std::optional<Note>> texture_notes(wanted.size());
  constexpr double kDecodeCostUs = 10'000;
  pool_.parallel_for(wanted.size(), kDecodeCostUs, [&](std::size_t i) {
    const Wanted& texture = wanted[i];
    out.textures[i].key = HashBuilder()
                              .add("texture")
                              .add(texture.image->encoded.hash())
                              .add(std::int64_t(texture.color_space))
                              .finish();
    if (resident_->contains(out.textures[i].key)) return;
    PreparedPixels prepared =
        prepare_texture(texture.image->encoded, texture.color_space, texture.image->pointer, config_.texture);
    out.textures[i].pixels = std::make_shared<const Image>(std::move(prepared.pixels));
    out.textures[i].lowest_green = prepared.lowest_green;
    texture_notes[i] = std::move(prepared.note);
  });
  for (auto& note : texture_notes) {
    if (note) notes.push_back(std::move(*note));
  }
  for (const PreparedTexture& texture : out.textures) hit = hit && texture.pixels == nullptr;
}

DecodedEnvironment SceneStore::decode(const EnvironmentSpec& spec) const {
  if (const auto* builtin = std::get_if<BuiltinName>(&spec.map)) {
    auto image = builtin_environment(builtin->name);
    if (!image) {
      fail(ErrorCode::kUnprocessable, fmt::format("there is no built-in environment \"{}\"", builtin->name),
           "/environment/map");
    }
    return {*std::move(image), {}};
  }
  if (const auto* file = std::get_if<EnvironmentFile>(&spec.map)) {
    try {
      return decode_environment(file->bytes, config_.environment);
    } catch (Error& error) {
      error.pointer = "/environment/map";
      throw;
    }
  }
  if (const auto* procedural = std::get_if<ProceduralEnvironment>(&spec.map))
    return {paint_environment(*procedural), {}};
  return {constant_environment(std::get<EnvironmentColor>(spec.map).radiance), {}};
}

StoredBake SceneStore::bake(const EnvironmentSpec& spec, const ContentHash& key, const Deadline& deadline,
                            StageTimes& times) {
  DecodedEnvironment decoded;
  {
    const Stopwatch watch(times.decode_ms);
    decoded = decode(spec);
  }
  const Stopwatch watch(times.bake_ms);
  StoredBake made{prepare_environment(std::move(decoded.equirect), key, pool_, deadline),
                  repair_notes(decoded.repairs)};
  made.environment.summary.repairs = decoded.repairs;
  return made;
}

std::shared_ptr<const StoredBake> SceneStore::environment(const EnvironmentSpec& spec,
                                                          const Deadline& deadline, StageTimes& times) {
  CacheOutcome outcome = CacheOutcome::kLoaded;
  const ContentHash key = environment_key(spec);
  // A constant colour is baked sooner than read.
  BakeStore* store = std::holds_alternative<EnvironmentColor>(spec.map) ? nullptr : bake_store_.get();
  auto environment = environments_.get_or_load(
      key, deadline,
      [&] {
        if (store != nullptr) {
          const Stopwatch watch(times.bake_ms);
          if (std::optional<StoredBake> stored = store->load(key)) {
            times.bake_from_disk = true;
            return *std::move(stored);
          }
        }
        return bake(spec, key, deadline, times);
      },
      &outcome);
  // Here, not in the load: those who wait for the bake need not wait for the disk.
  if (store != nullptr && outcome == CacheOutcome::kLoaded && !times.bake_from_disk)
    store->save(key, *environment);
  times.bake_hit = outcome == CacheOutcome::kHit || times.bake_from_disk;
  return environment;
}

EnvironmentAnswer SceneStore::environment_summary(const EnvironmentSpec& spec, const Deadline& deadline) {
  StageTimes times;
  const auto found = environment(spec, deadline, times);
  return {found->environment.summary, times.bake_hit};
}

Preparation SceneStore::prepare(const RenderSpec& spec, const Deadline& deadline, StageTimes& times) {
  Preparation out;
  {
    const Stopwatch watch(times.decode_ms);
    out.composed = compose(spec.scene, deadline, times.decode_hit);
    const Scene& scene = out.composed->scene;
    out.notes = scene.notes;
    out.scene.materials = scene.materials;
    out.scene.instances = scene.instances;
    prepare_meshes(out);
    check_deadline(deadline, "decode");
    prepare_textures(out.scene, scene, out.notes, times.decode_hit);
  }
  check_deadline(deadline, "bake");
  const auto environment = this->environment(spec.environment, deadline, times);
  out.scene.environment = std::shared_ptr<const PreparedEnvironment>(environment, &environment->environment);
  out.notes.insert(out.notes.end(), environment->notes.begin(), environment->notes.end());
  return out;
}

}  // namespace furnace
