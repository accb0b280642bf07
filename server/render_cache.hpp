// Finished renders by entity tag: in memory, then on disk. Equal renders that overlap in time are drawn once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "renderer/base/budget_cache.hpp"
#include "renderer/base/file_store.hpp"
#include "api/stored_render.hpp"

namespace furnace {

struct RenderCacheConfig {
  std::int64_t memory_bytes = 256ll << 20;
  std::filesystem::path folder;  // empty: nothing is kept on disk
  std::int64_t disk_bytes = 4096ll << 20;
};

// Where an answer came from.
enum class RenderOrigin { kDrawn, kJoined, kMemory, kDisk };

// Threads: any. Owns: shares of the renders, and the files below its folder.
class RenderCache {
 public:
  using Pointer = std::shared_ptr<const api::StoredRender>;
  struct Found {
    Pointer render;
    RenderOrigin origin = RenderOrigin::kDrawn;
  };

  explicit RenderCache(const RenderCacheConfig& config);

  // As BudgetCache::get_or_load; what was drawn goes to disk before it is answered.
  Found get_or_draw(const ContentHash& tag, const Deadline& deadline,
                    const std::function<api::StoredRender()>& draw);

  // Whether find would find it, as things stand.
  bool keeps(const ContentHash& tag);

  // Null when it is not kept, or not any more.
  Pointer find(const ContentHash& tag, const Deadline& deadline);

 private:
  BudgetCache<api::StoredRender> memory_;
  FileStore files_;
};

}  // namespace furnace
