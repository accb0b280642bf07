// Files kept under content hashes within a budget, so that a restart finds what was worked out before.
//
// FOLDER/vN/KEY.EXTENSION, N the version of what is in them. What its owner cannot use is set aside as
// FOLDER/vN/damaged/KEY.bad.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "renderer/base/deadline.hpp"

namespace furnace {

struct FileStoreConfig {
  std::filesystem::path folder;
  std::string_view name;       // of what is kept, in log events: "bakes" gives "bakes.damaged"; a constant
  std::string_view extension;  // a constant, without the dot
  int version = 1;
  std::int64_t budget_bytes =
      0;  // of all files below the folder, whatever their version, but the one just being
          // written; 0 or less keeps nothing and looks for nothing
  std::int64_t largest_bytes = 0;  // of one file
};

// The disk never fails a request: no function throws; trouble is logged, the same kind once a minute, and is a miss.
// Processes may share a folder: files change places whole (rename), and one that vanishes is a miss. After a crash at any
// instant there is the old file or the new one.
// Threads: any. Owns: the files below its folder; one object per folder and process.
class FileStore {
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
  explicit FileStore(FileStoreConfig config);
  FileStore(const FileStore&) = delete;
  FileStore& operator=(const FileStore&) = delete;

  // What `decode` (text -> Value) makes of the bytes that were saved under `key`, or nothing. An Error of it sets the file
  // aside. A file found counts as used now.
  template <class Decode>
  auto load(const ContentHash& key, Decode&& decode)
      -> std::optional<std::invoke_result_t<Decode&, std::string>> {
    if (config_.budget_bytes <= 0) return std::nullopt;
    std::optional<std::invoke_result_t<Decode&, std::string>> value;
    read(key, [&](std::string bytes) { value.emplace(decode(std::move(bytes))); });
    ++(value ? hits_ : misses_);
    return value;
  }

  // What `encode` () gives as bytes. False when the file is not there afterwards, or not surely so after a loss of power. Waits
  // for the disk; then removes what was not used for longest. What is larger than the budget is not kept.
  bool save(const ContentHash& key, const std::function<std::string()>& encode);

  // Whether there is a file, sound or not.
  bool contains(const ContentHash& key) const;

  Stats stats() const;
  // Where the file of `key` stands or would stand.
  std::filesystem::path path_of(const ContentHash& key) const;

 private:
  struct Complaint {
    Clock::time_point last;
    std::int64_t unsaid = 0;  // since then
  };
  enum class Kind { kForeign, kKept, kDamaged, kUnfinished };
  struct Listed;

  void read(const ContentHash& key, const std::function<void(std::string)>& use);
  Kind kind_of(const std::filesystem::path& path) const;
  std::vector<Listed> list_files(const std::filesystem::path& root) const;
  void set_aside(const std::filesystem::path& path, std::string_view reason);
  void remove_abandoned();
  void trim();
  void trim_damaged();
  void complain(std::string_view event, const std::filesystem::path& path, std::string_view reason);

  const FileStoreConfig config_;
  const std::filesystem::path current_;  // folder/vN
  std::atomic<std::int64_t> hits_{0}, misses_{0}, set_aside_{0}, saved_{0}, refused_{0}, trimmed_{0};
  std::atomic<std::int64_t> counted_bytes_{0};  // at the last count, and what was saved since
  std::atomic<int> saves_since_count_{0};
  std::mutex mutex_;                                  // of the member below
  std::map<std::string_view, Complaint> complaints_;  // by event, a constant
};

}  // namespace furnace
