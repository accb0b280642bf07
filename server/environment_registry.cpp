#include "server/environment_registry.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"
#include "renderer/image/encode.hpp"
#include "server/environment_report.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".environment";
constexpr std::size_t kLongestName = 64;

bool is_name(std::string_view name) {
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= kLongestName &&
         std::isalnum(static_cast<unsigned char>(name.front())) != 0 && std::ranges::all_of(name, allowed);
}

[[noreturn]] void fail_unknown(const std::string& name) {
  fail(ErrorCode::kNotFound,
       fmt::format("there is no environment \"{}\"; PUT /v1/environments/{{name}} makes one", name));
}

std::int64_t bytes_of(const EnvironmentBake& bake) {
  return std::int64_t(bake.maps->byte_size() + bake.riemann_irradiance.byte_size());
}

// Files that an earlier process kept. One that cannot be read is left alone and told of.
std::map<std::string, Blob> kept_files(const RegistryConfig& config) {
  std::map<std::string, Blob> files;
  std::error_code wrong;
  for (const fs::directory_entry& entry : fs::directory_iterator(config.folder, wrong)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != kEnding || !is_name(name)) continue;
    try {
      files.emplace(name, Blob(read_file(entry.path(), config.max_bytes)));
    } catch (const Error& error) {
      log::warning("environment.unreadable", {{"path", entry.path().string()}, {"message", error.message}});
    }
  }
  return files;
}

}  // namespace

EnvironmentRegistry::EnvironmentRegistry(Baker baker, WorkerPool& pool, RegistryConfig config)
    : baker_(std::move(baker)), pool_(pool), config_(std::move(config)), maps_(config_.maps_bytes, bytes_of) {
  if (!config_.folder.empty()) files_ = kept_files(config_);
}

api::EnvironmentReport EnvironmentRegistry::summary_of(const std::string& name, const Blob& file,
                                                       const Deadline& deadline) {
  EnvironmentSpec spec;
  spec.map = EnvironmentFile{file};
  const EnvironmentAnswer answer = [&] {
    try {
      return baker_(spec, deadline);
    } catch (Error& error) {
      error.pointer.clear();  // into a render request, which this is not
      throw;
    }
  }();
  return report_of(name, file, answer.summary, answer.was_cached);
}

EnvironmentRegistry::Put EnvironmentRegistry::put(const std::string& name, Blob file,
                                                  const Deadline& deadline) {
  if (!is_name(name)) {
    fail(ErrorCode::kInvalidRequest,
         "an environment's name is 1 to 64 letters, digits, dots, hyphens and underscores, beginning with a "
         "letter or digit");
  }
  Put put;
  put.report = summary_of(name, file, deadline);
  const std::lock_guard lock(mutex_);
  const std::int64_t others = std::accumulate(
      files_.begin(), files_.end(), std::int64_t{0}, [&](std::int64_t sum, const auto& entry) {
        return entry.first == name ? sum : sum + std::int64_t(entry.second.size());
      });
  if (others + std::int64_t(file.size()) > config_.max_bytes) {
    fail(ErrorCode::kTooLarge,
         fmt::format("all environments together may take {} bytes; delete one or raise --environments",
                     config_.max_bytes));
  }
  if (!config_.folder.empty()) {
    std::error_code wrong;
    fs::create_directories(config_.folder, wrong);
    write_file_atomically(config_.folder / (name + kEnding), file.text());
  }
  put.is_new = files_.insert_or_assign(name, std::move(file)).second;
  return put;
}

std::vector<std::string> EnvironmentRegistry::names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, file] : files_) names.push_back(name);
  return names;
}

std::optional<Blob> EnvironmentRegistry::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = files_.find(name);
  return found == files_.end() ? std::nullopt : std::optional(found->second);
}

Blob EnvironmentRegistry::file_of(const std::string& name) const {
  std::optional<Blob> file = find(name);
  if (!file) fail_unknown(name);
  return *std::move(file);
}

api::EnvironmentReport EnvironmentRegistry::report(const std::string& name, const Deadline& deadline) {
  return summary_of(name, file_of(name), deadline);
}

std::string EnvironmentRegistry::map_exr(const std::string& name, const std::string& map,
                                         const Deadline& deadline) {
  const Blob file = file_of(name);
  const auto bake = maps_.get_or_load(file.hash(), deadline, [&] {
    EnvironmentBakeSettings settings;
    settings.limits = config_.limits;
    return bake_whole_environment(file, settings, pool_, deadline);
  });
  for (const EnvironmentMap& candidate : bake->list()) {
    if (candidate.name == map) return encode_exr(*candidate.equirect, {});
  }
  fail(ErrorCode::kNotFound,
       fmt::format("environment \"{}\" has no map \"{}\"; its report lists them", name, map));
}

void EnvironmentRegistry::erase(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (files_.erase(name) == 0) fail_unknown(name);
  if (config_.folder.empty()) return;
  std::error_code wrong;
  fs::remove(config_.folder / (name + kEnding), wrong);
  if (wrong)
    fail(ErrorCode::kStorage,
         fmt::format("the file of \"{}\" could not be removed: {}", name, wrong.message()));
}

}  // namespace furnace
