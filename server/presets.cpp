#include "server/presets.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "api/problem.hpp"
#include "server/key_lines.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPresets = 10'000;

std::vector<fs::path> json_files(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, fault), end; !fault && entry != end; entry.increment(fault))
    if (entry->path().extension() == ".json" && files.size() <= kMaxPresets) files.push_back(entry->path());
  if (fault)
    fail(ErrorCode::kStorage, fmt::format("the folder of presets cannot be read: {}", fault.message()), {},
         folder.string());
  if (files.size() > kMaxPresets)
    fail(ErrorCode::kTooLarge, fmt::format("there are more than {} presets", kMaxPresets));
  std::ranges::sort(files);
  return files;
}

}  // namespace

Presets::Presets(const fs::path& folder, const api::JsonLimits& limits) {
  std::vector<Problem> problems;
  for (const fs::path& file : json_files(folder)) {
    const std::string name = file.stem().string(), place = file.filename().string();
    if (!is_key_name(name)) {
      problems.push_back({place, std::string(kKeyNameForm)});
      continue;
    }
    try {
      presets_.emplace(name, api::parse_preset(read_file(file, limits.max_bytes), limits));
    } catch (const Error& error) {
      if (error.problems.empty()) problems.push_back({place + error.pointer, error.message});
      for (const Problem& problem : error.problems)
        problems.push_back({place + problem.pointer, problem.message});
    }
  }
  problems.resize(std::min(problems.size(), api::kMaxProblems));
  api::fail_if_any(std::move(problems));
}

const api::Preset* Presets::find(std::string_view name) const {
  const auto found = presets_.find(name);
  return found == presets_.end() ? nullptr : &found->second;
}

}  // namespace furnace
