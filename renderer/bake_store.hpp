// Baked environments kept on disk, so that a restart does not bake again what was baked before.
//
// FOLDER/bakes/vN/KEY.exr, one file a bake (bake_file.hpp), N the version of its layout. What cannot be read is
// set aside as FOLDER/bakes/vN/damaged/KEY.bad.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>

#include "renderer/base/deadline.hpp"
#include "renderer/bake_file.hpp"

namespace furnace {

// The disk never fails a render: no function throws; trouble is logged, the same kind once a minute, and is a miss.
// Processes may share a folder: files change places whole (rename), and one that vanishes is a miss. After a crash at any
// instant there is the old file or the new one.
// Threads: any. Owns: the files below FOLDER/bakes; one object per folder and process.
class BakeStore {
 public:
  struct Stats {
    std::int64_t hits = 0;
    std::int64_t misses = 0;     // nothing, or nothing that can be used, was there
    std::int64_t set_aside = 0;  // damaged or foreign files, each also a miss
    std::int64_t saved = 0;
    std::int64_t refused = 0;  // saves that did not end in a file
    std::int64_t trimmed = 0;  // files removed to keep the budget
  };

  // Removes what earlier processes left half written, and keeps the budget. The folder is made by the first save.
  // `budget_bytes`: of all files below FOLDER/bakes, whatever their version, but the one just being written; 0 or less
  // keeps nothing and looks for nothing.
  BakeStore(std::filesystem::path folder, std::int64_t budget_bytes);
  BakeStore(const BakeStore&) = delete;
  BakeStore& operator=(const BakeStore&) = delete;

  // Exactly what was saved under `key`, or nothing. A file found counts as used now.
  std::optional<StoredBake> load(const ContentHash& key);

  // False when the file is not there afterwards, or not surely so after a loss of power. Waits for the disk; then removes
  // what was not used for longest. A bake larger than the budget is not kept.
  bool save(const ContentHash& key, const StoredBake& bake);

  Stats stats() const;
  // Where the bake of `key` stands or would stand.
  std::filesystem::path path_of(const ContentHash& key) const;

 private:
  struct Complaint {
    Clock::time_point last;
    std::int64_t unsaid = 0;  // since then
  };

  std::optional<StoredBake> read(const ContentHash& key);
  void set_aside(const std::filesystem::path& path, std::string_view reason);
  void remove_abandoned();
  void trim();
  void trim_damaged();
  void complain(std::string_view event, const std::filesystem::path& path, std::string_view reason);

  const std::filesystem::path root_;     // FOLDER/bakes
  const std::filesystem::path current_;  // root_/vN
  const std::int64_t budget_bytes_;
  std::atomic<std::int64_t> hits_{0}, misses_{0}, set_aside_{0}, saved_{0}, refused_{0}, trimmed_{0};
  std::mutex mutex_;                                  // of the member below
  std::map<std::string_view, Complaint> complaints_;  // by event, a constant
};

}  // namespace furnace
