#include "renderer/environment_store.hpp"

#include <functional>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/stopwatch.hpp"
#include "renderer/ibl/blur.hpp"
#include "renderer/prepare.hpp"
#include "renderer/scene/procedural.hpp"

namespace furnace {
namespace {

ContentHash map_key(const EnvironmentMapSpec& map) {
  HashBuilder key;
  key.add("environment").add(std::int64_t(kBakeVersion));
  if (const auto* builtin = std::get_if<BuiltinName>(&map)) {
    key.add("builtin").add(builtin->name);
  } else if (const auto* file = std::get_if<EnvironmentFile>(&map)) {
    key.add("file").add(file->bytes.hash()).add(name_of(file->layout));
  } else if (const auto* procedural = std::get_if<ProceduralEnvironment>(&map)) {
    key.add("procedural").add(procedural_hash(*procedural));
  } else {
    const glm::vec3 radiance = std::get<EnvironmentColor>(map).radiance;
    key.add("color").add(double(radiance.r)).add(double(radiance.g)).add(double(radiance.b));
  }
  return key.finish();
}

std::vector<Note> repair_notes(const RepairReport& repairs, const char* pointer) {
  const std::int64_t count = repairs.nan_samples + repairs.infinite_samples + repairs.negative_samples;
  if (count == 0) return {};
  return {{"environment-repaired", pointer,
           fmt::format("the environment had {} NaN, {} infinite and {} negative samples, which were replaced",
                       repairs.nan_samples, repairs.infinite_samples, repairs.negative_samples)}};
}

// A bake tells more often than anybody wants to hear.
BakeProgress in_percents(const TellStage& tell) {
  if (!tell) return {};
  return [&tell, told = -1](double fraction) mutable {
    if (const int percent = int(100 * fraction); percent > told) tell("bake", 0.01 * (told = percent));
  };
}

enum class Origin { kMemory, kDisk, kMade };

// From memory, else by `load` from the disk, else by `make`, kept by `save`; either may be empty.
template <class Value>
std::shared_ptr<const Value> find(BudgetCache<Value>& cache, const ContentHash& key, const Deadline& deadline,
                                  StageTimes& times, const std::function<std::optional<Value>()>& load,
                                  const std::function<Value()>& make,
                                  const std::function<void(const Value&)>& save, Origin& origin) {
  origin = Origin::kMade;
  CacheOutcome outcome = CacheOutcome::kLoaded;
  auto value = cache.get_or_load(
      key, deadline,
      [&] {
        if (load) {
          const Stopwatch watch(times.bake_ms);
          if (std::optional<Value> stored = load()) {
            origin = Origin::kDisk;
            return *std::move(stored);
          }
        }
        return make();
      },
      &outcome);
  if (outcome == CacheOutcome::kHit) origin = Origin::kMemory;
  // Here, not in the load: those who wait for it need not wait for the disk.
  if (save && outcome == CacheOutcome::kLoaded && origin == Origin::kMade) save(*value);
  return value;
}

}  // namespace

EnvironmentStore::EnvironmentStore(const RendererConfig& config, WorkerPool& pool, Decoder& decoder)
    : limits_(config.environment),
      pool_(pool),
      decoder_(decoder),
      baked_(config.bake_cache_bytes,
             [](const StoredBake& bake) { return std::int64_t(bake.environment.byte_size()); }),
      backgrounds_(
          config.background_cache_bytes,
          [](const StoredBackground& background) { return std::int64_t(background.sky.byte_size()); }),
      bake_store_(config.data_folder.empty()
                      ? nullptr
                      : std::make_unique<BakeStore>(config.data_folder, config.disk_cache_bytes)) {}

DecodedEnvironment EnvironmentStore::decode(const EnvironmentMapSpec& map, const char* pointer,
                                            const Deadline& deadline, StageTimes& times) const {
  const Stopwatch watch(times.decode_ms);
  if (const auto* builtin = std::get_if<BuiltinName>(&map)) {
    auto image = builtin_environment(builtin->name);
    if (!image) {
      fail(ErrorCode::kUnprocessable, fmt::format("there is no built-in environment \"{}\"", builtin->name),
           pointer);
    }
    return {*std::move(image), {}};
  }
  if (const auto* file = std::get_if<EnvironmentFile>(&map)) {
    try {
      return decoder_.environment(file->bytes, file->layout, limits_, deadline);
    } catch (Error& error) {
      error.pointer = pointer;
      throw;
    }
  }
  if (const auto* procedural = std::get_if<ProceduralEnvironment>(&map))
    return {paint_environment(*procedural, {&pool_, deadline}), {}};
  return {constant_environment(std::get<EnvironmentColor>(map).radiance), {}};
}

StoredBake EnvironmentStore::bake(const EnvironmentMapSpec& map, bool extracts_suns, const ContentHash& key,
                                  const Deadline& deadline, const TellStage& tell, StageTimes& times) const {
  DecodedEnvironment decoded = decode(map, "/environment/map", deadline, times);
  const Stopwatch watch(times.bake_ms);
  StoredBake made{prepare_environment(std::move(decoded.equirect), extracts_suns, key, pool_, deadline,
                                      in_percents(tell)),
                  repair_notes(decoded.repairs, "/environment/map")};
  made.environment.summary.repairs = decoded.repairs;
  made.environment.summary.layout = decoded.layout;
  return made;
}

StoredBackground EnvironmentStore::make_background(const EnvironmentMapSpec& map, double blur_rad,
                                                   const ContentHash& key, const Deadline& deadline,
                                                   StageTimes& times) const {
  constexpr const char* kPointer = "/environment/background/map";
  const DecodedEnvironment decoded = decode(map, kPointer, deadline, times);
  const Stopwatch watch(times.bake_ms);
  std::vector<Note> notes = repair_notes(decoded.repairs, kPointer);
  if (blur_rad == 0) return {prepare_sky(decoded.equirect, key, pool_), std::move(notes)};
  return {prepare_sky(blurred_environment(decoded.equirect, blur_rad, pool_, deadline), key, pool_),
          std::move(notes)};
}

BakeStore* EnvironmentStore::disk_for(const EnvironmentMapSpec& map) const {
  // A constant colour is made sooner than read.
  return std::holds_alternative<EnvironmentColor>(map) ? nullptr : bake_store_.get();
}

std::shared_ptr<const StoredBake> EnvironmentStore::baked(const EnvironmentMapSpec& map, SunMode sun,
                                                          const Deadline& deadline, const TellStage& tell,
                                                          StageTimes& times) {
  const bool extracts_suns = sun != SunMode::kKeep;
  const ContentHash key =
      extracts_suns ? HashBuilder().add("without suns").add(map_key(map)).finish() : map_key(map);
  std::function<std::optional<StoredBake>()> load;
  std::function<void(const StoredBake&)> save;
  if (BakeStore* const disk = disk_for(map)) {
    load = [&key, disk] { return disk->load(key); };
    save = [&key, disk](const StoredBake& made) { disk->save(key, made); };
  }
  Origin origin = Origin::kMade;
  auto environment = find<StoredBake>(
      baked_, key, deadline, times, load,
      [&] { return bake(map, extracts_suns, key, deadline, tell, times); }, save, origin);
  times.bake_hit = origin != Origin::kMade;
  times.bake_from_disk = origin == Origin::kDisk;
  return environment;
}

std::shared_ptr<const StoredBackground> EnvironmentStore::background(const EnvironmentMapSpec& map,
                                                                     double blur_rad,
                                                                     const Deadline& deadline,
                                                                     StageTimes& times) {
  const ContentHash key = HashBuilder().add("background").add(map_key(map)).add(blur_rad).finish();
  std::function<std::optional<StoredBackground>()> load;
  std::function<void(const StoredBackground&)> save;
  if (BakeStore* const disk = disk_for(map)) {
    load = [&key, disk] { return disk->load_background(key); };
    save = [&key, disk](const StoredBackground& made) { disk->save_background(key, made); };
  }
  Origin origin = Origin::kMade;
  auto background = find<StoredBackground>(
      backgrounds_, key, deadline, times, load,
      [&] { return make_background(map, blur_rad, key, deadline, times); }, save, origin);
  times.bake_hit = times.bake_hit && origin != Origin::kMade;
  times.bake_from_disk = times.bake_hit && (times.bake_from_disk || origin == Origin::kDisk);
  return background;
}

}  // namespace furnace
