// Assets that come in over several requests: what is there of each, below a folder, by the hash that it will have and by who
// sends it, so that nobody writes on what another has begun.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "renderer/base/content_hash.hpp"
#include "server/upload_file.hpp"

namespace furnace {

struct PartialUploadsConfig {
  using Time = std::filesystem::file_time_type;
  std::filesystem::path folder;
  std::int64_t budget_bytes = 0;     // of all together
  std::chrono::milliseconds ttl{0};  // nothing came for longer: removed; 0: never
  std::function<Time()> now = Time::clock::now;
  int max_files = 1000;
  int max_files_of_client = 100;
};

// Threads: any. Owns: the files below its folder, which other processes may share.
class PartialUploads {
 public:
  struct Id {
    ContentHash hash;
    std::string client;  // the key's name; "" without keys
  };

  explicit PartialUploads(PartialUploadsConfig config) : config_(std::move(config)) {}

  // Bytes that are there: 0 of what was never begun, or not any more.
  std::int64_t received(const Id& id) const;
  // To go on with, `more_bytes` at most; not open when another request does so just now.
  // Errors: kOverloaded when there are too many or too much, kStorage.
  UploadFile open(const Id& id, std::int64_t more_bytes);
  void remove_stale();

 private:
  struct Sum {
    std::int64_t bytes = 0;
    int files = 0;
    int files_of_sender = 0;
  };
  std::filesystem::path path_of(const Id& id) const;
  Sum sweep(const std::string& sender);

  const PartialUploadsConfig config_;
  std::mutex mutex_;  // what is counted is opened before others count
};

}  // namespace furnace
