#include "server/partial_uploads.hpp"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".partial";

std::string ending_of(const std::string& client) {
  return fmt::format("-{}{}", HashBuilder().add(client).finish().hex().substr(0, 16), kEnding);
}

}  // namespace

fs::path PartialUploads::path_of(const Id& id) const {
  return config_.folder / (id.hash.hex() + ending_of(id.client));
}

std::int64_t PartialUploads::received(const Id& id) const {
  std::error_code missing;
  const auto bytes = fs::file_size(path_of(id), missing);
  return missing ? 0 : std::int64_t(bytes);
}

UploadFile PartialUploads::open(const Id& id, std::int64_t more_bytes) {
  const std::lock_guard lock(mutex_);
  const Sum there = sweep(ending_of(id.client));
  std::error_code unknown;
  const bool is_new = !fs::exists(path_of(id), unknown);
  if (there.bytes + more_bytes > config_.budget_bytes ||
      (is_new &&
       (there.files >= config_.max_files || there.files_of_sender >= config_.max_files_of_client))) {
    fail(ErrorCode::kOverloaded,
         "Too many uploads are incomplete; finish some, or try again when they are forgotten.");
  }
  return UploadFile::resume(path_of(id));
}

void PartialUploads::remove_stale() {
  const std::lock_guard lock(mutex_);
  sweep({});
}

// What is left once that has been removed to which nothing came for long; what another writes just now stays.
PartialUploads::Sum PartialUploads::sweep(const std::string& sender) {
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
    if (!sender.empty() && entry.path().filename().string().ends_with(sender)) ++sum.files_of_sender;
  }
  return sum;
}

}  // namespace furnace
