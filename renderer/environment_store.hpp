// Environments: decoded, baked, blurred, through byte-bounded caches in memory and on disk.
#pragma once

#include <memory>

#include "renderer/bake_store.hpp"
#include "renderer/base/budget_cache.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/renderer.hpp"
#include "renderer/scene/decoder.hpp"

namespace furnace {

// Threads: any. Owns: the caches of baked environments and of backgrounds.
class EnvironmentStore {
 public:
  // `pool` and `decoder` outlive it.
  EnvironmentStore(const RendererConfig& config, WorkerPool& pool, Decoder& decoder);

  // From memory, from disk, or baked, which is told to `tell`. Adds to decode_ms and bake_ms of `times`. Errors: those of decoding and baking, with the
  // pointer /environment/map.
  std::shared_ptr<const StoredBake> baked(const EnvironmentMapSpec& map, SunMode sun,
                                          const Deadline& deadline, const TellStage& tell, StageTimes& times);

  // A map to be looked at only, likewise. Errors: the same, with the pointer /environment/background/map.
  std::shared_ptr<const StoredBackground> background(const EnvironmentMapSpec& map, double blur_rad,
                                                     const Deadline& deadline, StageTimes& times);

  CacheStats baked_stats() const { return baked_.stats(); }

 private:
  DecodedEnvironment decode(const EnvironmentMapSpec& map, const char* pointer, const Deadline& deadline,
                            StageTimes& times) const;
  StoredBackground make_background(const EnvironmentMapSpec& map, double blur_rad, const ContentHash& key,
                                   const Deadline& deadline, StageTimes& times) const;
  BakeStore* disk_for(const EnvironmentMapSpec& map) const;  // null: not kept there
  StoredBake bake(const EnvironmentMapSpec& map, bool extracts_suns, const ContentHash& key,
                  const Deadline& deadline, const TellStage& tell, StageTimes& times) const;

  const DecodeLimits limits_;
  WorkerPool& pool_;
  Decoder& decoder_;
  BudgetCache<StoredBake> baked_;
  BudgetCache<StoredBackground> backgrounds_;
  std::unique_ptr<BakeStore> bake_store_;  // null without a data folder
};

}  // namespace furnace
