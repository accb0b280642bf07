#include "server/environment_files.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "server/upload_file.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".environment";
constexpr std::size_t kLongestName = 64;
constexpr std::int64_t kLeastCharge = 4096;

bool is_name(std::string_view name) {
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= kLongestName &&
         std::isalnum(static_cast<unsigned char>(name.front())) != 0 && std::ranges::all_of(name, allowed);
}

[[noreturn]] void fail_unknown(const std::string& name) {
  fail(ErrorCode::kNotFound, fmt::format("there is no environment \"{}\"", name));
}

std::vector<fs::path> roots(const fs::path& folder) {
  return folder.empty() ? std::vector<fs::path>{} : std::vector<fs::path>{folder};
}

}  // namespace

EnvironmentFiles::EnvironmentFiles(fs::path folder, std::int64_t budget_bytes)
    : folder_(std::move(folder)),
      budget_bytes_(budget_bytes),
      on_disk_(roots(folder_), budget_bytes, budget_bytes) {
  if (!folder_.empty()) UploadFile::remove_abandoned(folder_);
}

std::map<std::string, std::int64_t> EnvironmentFiles::sizes() const {
  std::map<std::string, std::int64_t> sizes;
  if (folder_.empty()) {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, file] : in_memory_) sizes[name] = std::int64_t(file.size());
    return sizes;
  }
  std::error_code wrong;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, wrong)) {
    const std::string name = entry.path().stem().string();
    const std::uintmax_t size = entry.file_size(wrong);
    if (entry.path().extension() == kEnding && is_name(name) && !wrong) sizes[name] = std::int64_t(size);
  }
  return sizes;
}

void EnvironmentFiles::check_name(std::string_view name) {
  if (is_name(name)) return;
  fail(ErrorCode::kInvalidRequest,
       "an environment's name is 1 to 64 letters, digits, dots, hyphens and underscores, beginning with a "
       "letter or digit");
}

bool EnvironmentFiles::put(const std::string& name, const Blob& file) {
  check_name(name);
  const std::lock_guard changing(change_mutex_);
  std::map<std::string, std::int64_t> all = sizes();
  const bool is_new = !all.contains(name);
  all[name] = std::int64_t(file.size());
  std::int64_t total = 0;
  for (const auto& [other, bytes] : all) total += std::max(bytes, kLeastCharge);
  if (total > budget_bytes_) {
    fail(ErrorCode::kTooLarge,
         fmt::format("all environments together may take {} bytes; delete one or raise --environments",
                     budget_bytes_));
  }
  if (folder_.empty()) {
    const std::lock_guard lock(mutex_);
    in_memory_.insert_or_assign(name, file);
    return is_new;
  }
  UploadFile coming(folder_);
  coming.append(file.text());
  coming.publish(folder_ / (name + kEnding));
  return is_new;
}

void EnvironmentFiles::erase(const std::string& name) {
  const std::lock_guard changing(change_mutex_);
  if (!sizes().contains(name)) fail_unknown(name);
  if (folder_.empty()) {
    const std::lock_guard lock(mutex_);
    in_memory_.erase(name);
    return;
  }
  std::error_code wrong;
  fs::remove(folder_ / (name + kEnding), wrong);
  if (wrong)
    fail(ErrorCode::kStorage, fmt::format("the file of \"{}\" cannot be removed", name), {}, wrong.message());
}

std::optional<Blob> EnvironmentFiles::find(const std::string& name) {
  if (!is_name(name)) return std::nullopt;
  if (folder_.empty()) {
    const std::lock_guard lock(mutex_);
    const auto found = in_memory_.find(name);
    return found == in_memory_.end() ? std::nullopt : std::optional(found->second);
  }
  try {
    return on_disk_.read(name + kEnding, {});
  } catch (const Error& error) {
    if (error.code == ErrorCode::kNotFound) return std::nullopt;
    throw;
  }
}

std::vector<std::string> EnvironmentFiles::names() const {
  std::vector<std::string> names;
  for (const auto& [name, bytes] : sizes()) names.push_back(name);
  return names;
}

}  // namespace furnace
