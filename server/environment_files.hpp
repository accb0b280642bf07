// The files of named environments: below a folder, where other processes may share them, or in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/blob.hpp"

namespace furnace {

// Threads: any; changes wait for one another, readers for no disk but their own. Owns: the files, or a cache of them.
class EnvironmentFiles {
 public:
  // `folder` is made by the first put; empty: in memory, gone with the process. `budget_bytes`: of all files together, each
  // counted as 4 KiB at least, so that their number is bounded too.
  EnvironmentFiles(std::filesystem::path folder, std::int64_t budget_bytes);

  // Errors: kInvalidRequest for a name other than 1 to 64 of A-Z a-z 0-9 . _ - beginning with a letter or digit.
  static void check_name(std::string_view name);

  // True for a new name; a name that is taken gets the new file. Errors: those of check_name; kTooLarge over the budget;
  // kStorage.
  bool put(const std::string& name, const Blob& file);
  // Errors: kNotFound, kStorage.
  void erase(const std::string& name);
  // None when there is no such name. Errors: kStorage.
  std::optional<Blob> find(const std::string& name);
  std::vector<std::string> names() const;  // sorted

 private:
  std::map<std::string, std::int64_t> sizes() const;  // bytes by name

  const std::filesystem::path folder_;
  const std::int64_t budget_bytes_;
  std::mutex change_mutex_;
  mutable std::mutex mutex_;  // of the member below
  std::map<std::string, Blob> in_memory_;
  FileAssets on_disk_;
};

}  // namespace furnace
