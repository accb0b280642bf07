#include "renderer/environment_store.hpp"

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
    key.add("file").add(file->bytes.hash());
  } else if (const auto* procedural = std::get_if<ProceduralEnvironment>(&map)) {
    key.add("procedural").add(procedural_hash(*procedural));
  } else {
    const glm::vec3 radiance = std::get<EnvironmentColor>(map).radiance;
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

EnvironmentStore::EnvironmentStore(const RendererConfig& config, WorkerPool& pool, Decoder& decoder)
    : limits_(config.environment),
      pool_(pool),
      decoder_(decoder),
      baked_(config.bake_cache_bytes,
             [](const StoredBake& bake) { return std::int64_t(bake.environment.byte_size()); }),
      backgrounds_(config.background_cache_bytes,
                   [](const PreparedSky& sky) { return std::int64_t(sky.byte_size()); }),
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
      return decoder_.environment(file->bytes, limits_, deadline);
    } catch (Error& error) {
      error.pointer = pointer;
      throw;
    }
  }
  if (const auto* procedural = std::get_if<ProceduralEnvironment>(&map))
    return {paint_environment(*procedural), {}};
  return {constant_environment(std::get<EnvironmentColor>(map).radiance), {}};
}

StoredBake EnvironmentStore::bake(const EnvironmentMapSpec& map, bool extracts_suns, const ContentHash& key,
                                  const Deadline& deadline, StageTimes& times) const {
  DecodedEnvironment decoded = decode(map, "/environment/map", deadline, times);
  const Stopwatch watch(times.bake_ms);
  StoredBake made{prepare_environment(std::move(decoded.equirect), extracts_suns, key, pool_, deadline),
                  repair_notes(decoded.repairs)};
  made.environment.summary.repairs = decoded.repairs;
  return made;
}

std::shared_ptr<const StoredBake> EnvironmentStore::baked(const EnvironmentMapSpec& map, SunMode sun,
                                                          const Deadline& deadline, StageTimes& times) {
  CacheOutcome outcome = CacheOutcome::kLoaded;
  const bool extracts_suns = sun != SunMode::kKeep;
  const ContentHash key =
      extracts_suns ? HashBuilder().add("without suns").add(map_key(map)).finish() : map_key(map);
  // A constant colour is baked sooner than read.
  BakeStore* store = std::holds_alternative<EnvironmentColor>(map) ? nullptr : bake_store_.get();
  auto environment = baked_.get_or_load(
      key, deadline,
      [&] {
        if (store != nullptr) {
          const Stopwatch watch(times.bake_ms);
          if (std::optional<StoredBake> stored = store->load(key)) {
            times.bake_from_disk = true;
            return *std::move(stored);
          }
        }
        return bake(map, extracts_suns, key, deadline, times);
      },
      &outcome);
  // Here, not in the load: those who wait for the bake need not wait for the disk.
  if (store != nullptr && outcome == CacheOutcome::kLoaded && !times.bake_from_disk)
    store->save(key, *environment);
  times.bake_hit = outcome == CacheOutcome::kHit || times.bake_from_disk;
  return environment;
}

std::shared_ptr<const PreparedSky> EnvironmentStore::background(const EnvironmentMapSpec& map,
                                                                double blur_rad, const Deadline& deadline,
                                                                StageTimes& times) {
  const ContentHash key = HashBuilder().add("background").add(map_key(map)).add(blur_rad).finish();
  return backgrounds_.get_or_load(key, deadline, [&] {
    const Image radiance = decode(map, "/environment/background/map", deadline, times).equirect;
    const Stopwatch watch(times.bake_ms);
    if (blur_rad == 0) return prepare_sky(radiance, key, pool_);
    return prepare_sky(blurred_environment(radiance, blur_rad, pool_, deadline), key, pool_);
  });
}

}  // namespace furnace
