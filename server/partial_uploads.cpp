#include "server/partial_uploads.hpp"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".partial";

}  // namespace

fs::path PartialUploads::path_of(const Id& id) const {
  const std::string sender = HashBuilder().add(id.client).finish().hex().substr(0, 16);
  return config_.folder / fmt::format("{}-{}{}", id.hash.hex(), sender, kEnding);
}

std::int64_t PartialUploads::received(const Id& id) const {
  std::error_code missing;
  const auto bytes = fs::file_size(path_of(id), missing);
  return missing ? 0 : std::int64_t(bytes);
}

UploadFile PartialUploads::open(const Id& id, std::int64_t more_bytes) {
  const std::lock_guard lock(mutex_);
  const Sum there = sweep();
  if (there.bytes + more_bytes > config_.budget_bytes || there.files >= config_.max_files) {
    fail(ErrorCode::kOverloaded,
         "Too many uploads are incomplete; finish some, or try again when they are forgotten.");
  }
  return UploadFile::resume(path_of(id));
}

void PartialUploads::remove_stale() {
  const std::lock_guard lock(mutex_);
  sweep();
}

// What is left once that has been removed to which nothing came for long; what another writes just now stays.
PartialUploads::Sum PartialUploads::sweep() {
  Sum sum;
  std::error_code wrong;
  for (const fs::directory_entry& entry : fs::directory_iterator(config_.folder, wrong)) {
    if (entry.path().extension() != kEnding) continue;
    std::error_code gone;
    const auto bytes = std::int64_t(entry.file_size(gone));
    const auto used = gone ? PartialUploadsConfig::Time{} : entry.last_write_time(gone);
    if (gone) continue;
    if (config_.ttl.count() > 0 && config_.now() - used > config_.ttl) {
      UploadFile stale = UploadFile::resume(entry.path());
      if (stale.is_open()) {
        stale.remove();
        continue;
      }
    }
    sum.bytes += bytes;
    ++sum.files;
  }
  return sum;
}

}  // namespace furnace
