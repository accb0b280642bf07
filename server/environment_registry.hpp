// The environments that users have named: their reports and their maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "api/environment_report.hpp"
#include "renderer/base/budget_cache.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/environment_bake.hpp"
#include "renderer/renderer.hpp"
#include "server/admission.hpp"
#include "server/environment_files.hpp"

namespace furnace {

struct RegistryConfig {
  std::filesystem::path folder;            // of the files; empty: in memory
  std::int64_t files_bytes = 512ll << 20;  // of all files together
  std::int64_t maps_bytes = 256ll << 20;   // baked maps kept for downloads
  DecodeLimits limits{8192, 8192ll * 4096};
};

// What bakes takes a seat, as a render does.
// Threads: any. Owns: the files and the maps; Admission, WorkerPool and Decoder outlive it.
class EnvironmentRegistry {
 public:
  // Bakes as a render would, or finds what was baked: Renderer::environment.
  using Baker = std::function<EnvironmentAnswer(const EnvironmentSpec&, const Deadline&)>;
  EnvironmentRegistry(Baker baker, Admission& admission, WorkerPool& pool, Decoder& decoder,
                      RegistryConfig config);

  struct Put {
    api::EnvironmentReport report;
    bool is_new = false;
  };
  // Bakes and keeps. Errors: those of EnvironmentFiles::put; kUnsupportedMedia, kUnprocessable, kTooLarge of the file;
  // kOverloaded; kDeadlineExceeded.
  Put put(const std::string& name, const Blob& file, const Deadline& deadline);

  std::vector<std::string> names() const { return files_.names(); }
  // Errors: kNotFound, kOverloaded; those of baking.
  api::EnvironmentReport report(const std::string& name, const Deadline& deadline);
  // A map by the name that the report gives it, as EXR. Errors: kNotFound, kOverloaded; those of baking.
  std::string map_exr(const std::string& name, const std::string& map, const Deadline& deadline);
  void erase(const std::string& name) { files_.erase(name); }  // Errors: kNotFound, kStorage

  // The file, for requests that name it. None when there is no such name.
  std::optional<Blob> find(const std::string& name) { return files_.find(name); }

 private:
  Blob file_of(const std::string& name);
  api::EnvironmentReport summary_of(const std::string& name, const Blob& file, const Deadline& deadline);

  const Baker baker_;
  Admission& admission_;
  WorkerPool& pool_;
  Decoder& decoder_;
  const DecodeLimits limits_;
  EnvironmentFiles files_;
  BudgetCache<EnvironmentBake> maps_;  // by the file's hash
};

}  // namespace furnace
