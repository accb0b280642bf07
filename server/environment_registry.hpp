// The environments that users have named: their files, their reports, their maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/environment_report.hpp"
#include "renderer/base/budget_cache.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/environment_bake.hpp"
#include "renderer/renderer.hpp"

namespace furnace {

struct RegistryConfig {
  std::filesystem::path folder;           // where the files are kept; empty: in memory, gone with the process
  std::int64_t max_bytes = 512ll << 20;   // of all files together
  std::int64_t maps_bytes = 256ll << 20;  // baked maps kept for downloads
  DecodeLimits limits{8192, 8192ll * 4096};
};

// Threads: any. Owns: the names and, without a folder, the files.
class EnvironmentRegistry {
 public:
  // Bakes as a render would, or finds what was baked: Renderer::environment.
  using Baker = std::function<EnvironmentAnswer(const EnvironmentSpec&, const Deadline&)>;
  EnvironmentRegistry(Baker baker, WorkerPool& pool, RegistryConfig config);

  struct Put {
    api::EnvironmentReport report;
    bool is_new = false;
  };
  // Bakes and keeps; a name that is taken gets the new file. Errors: kInvalidRequest for a name other than 1 to 64 of
  // A-Z a-z 0-9 . _ - beginning with a letter or digit; kUnsupportedMedia, kUnprocessable, kTooLarge of the file;
  // kTooLarge when all files together exceed the budget; kStorage; kDeadlineExceeded.
  Put put(const std::string& name, Blob file, const Deadline& deadline);

  std::vector<std::string> names() const;  // sorted
  // Errors: kNotFound; those of baking.
  api::EnvironmentReport report(const std::string& name, const Deadline& deadline);
  // A map by the name that the report gives it, as EXR. Errors: kNotFound, those of baking.
  std::string map_exr(const std::string& name, const std::string& map, const Deadline& deadline);
  void erase(const std::string& name);  // Errors: kNotFound, kStorage.

  // The file, for requests that name it. None when there is no such name.
  std::optional<Blob> find(const std::string& name) const;

 private:
  Blob file_of(const std::string& name) const;
  api::EnvironmentReport summary_of(const std::string& name, const Blob& file, const Deadline& deadline);

  const Baker baker_;
  WorkerPool& pool_;
  const RegistryConfig config_;
  mutable std::mutex mutex_;
  std::map<std::string, Blob> files_;
  BudgetCache<EnvironmentBake> maps_;  // by the file's hash
};

}  // namespace furnace
