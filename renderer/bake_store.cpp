#include "renderer/bake_store.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/base/log.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;
using FileTime = fs::file_time_type;

constexpr std::size_t kDamagedKept = 16;                 // for whoever wants to know what happened
constexpr auto kQuiet = std::chrono::minutes(1);         // between two lines of one kind
constexpr auto kAbandonedAfter = std::chrono::hours(1);  // no write lasts as long

enum class Kind { kForeign, kBake, kDamaged, kUnfinished };

// Nothing but what this store names is ever removed. Unfinished is what write_file_atomically writes to:
// .KEY.exr.PID.SERIAL.tmp.
Kind kind_of(const fs::path& path) {
  const std::string text = path.filename().string();
  std::string_view name = text;
  const bool is_hidden = name.starts_with('.');
  if (is_hidden) name.remove_prefix(1);
  constexpr std::size_t kKeyDigits = 2 * sizeof(ContentHash::bytes);
  const std::string_view key = name.substr(0, kKeyDigits), rest = name.substr(key.size());
  if (key.size() != kKeyDigits || key.find_first_not_of("0123456789abcdef") != key.npos)
    return Kind::kForeign;
  if (is_hidden)
    return rest.starts_with(".exr.") && rest.ends_with(".tmp") ? Kind::kUnfinished : Kind::kForeign;
  return rest == ".exr" ? Kind::kBake : rest == ".bad" ? Kind::kDamaged : Kind::kForeign;
}

struct Listed {
  fs::path path;
  Kind kind;
  FileTime used;
  std::int64_t bytes;
};

// What vanishes meanwhile is left out.
std::vector<Listed> list_files(const fs::path& root) {
  std::vector<Listed> files;
  std::error_code end;
  for (fs::recursive_directory_iterator it(root, end), last; !end && it != last; it.increment(end)) {
    std::error_code error;
    const Kind kind = kind_of(it->path());
    if (kind == Kind::kForeign || !it->is_regular_file(error) || it->is_symlink(error)) continue;
    const FileTime used = it->last_write_time(error);
    const auto bytes = error ? 0 : it->file_size(error);
    if (!error) files.push_back({it->path(), kind, used, std::int64_t(bytes)});
  }
  return files;
}

bool remove_file(const fs::path& path) {
  std::error_code error;
  return fs::remove(path, error);
}

void mark_used_now(const fs::path& path) {
  std::error_code error;  // a folder that can only be read keeps its order
  fs::last_write_time(path, FileTime::clock::now(), error);
}

// Our own number counts as ended: the folder is this object's alone in this process, and in a container every life of the
// server has the same number. Numbers mean nothing without /proc, and another machine's are not in ours: what is removed
// from under a living process costs it one save.
bool writer_has_ended(const fs::path& unfinished) {
  const std::string dot_pid = unfinished.stem().stem().extension().string();
  const std::string pid = dot_pid.substr(std::min<std::size_t>(1, dot_pid.size()));
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self", error);
  return !error && (own.string() == pid || (!fs::exists("/proc/" + pid, error) && !error));
}

}  // namespace

BakeStore::BakeStore(fs::path folder, std::int64_t budget_bytes)
    : root_(std::move(folder) / "bakes"),
      current_(root_ / fmt::format("v{}", kBakeFileLayout)),
      budget_bytes_(budget_bytes) {
  if (budget_bytes_ <= 0) return;
  try {
    remove_abandoned();
    trim();
  } catch (const std::exception& error) {
    complain("bakes.trim_failed", root_, error.what());
  }
}

fs::path BakeStore::path_of(const ContentHash& key) const {
  return current_ / (key.hex() + ".exr");
}

std::optional<StoredBake> BakeStore::load(const ContentHash& key) {
  if (budget_bytes_ <= 0) return std::nullopt;
  auto bake = read(key);
  ++(bake ? hits_ : misses_);
  return bake;
}

std::optional<StoredBake> BakeStore::read(const ContentHash& key) {
  try {
    const fs::path path = path_of(key);
    try {
      const std::string file = read_file(path, std::min(kLargestBakeFileBytes, budget_bytes_));
      StoredBake bake = decode_bake(key, file);
      mark_used_now(path);
      return bake;
    } catch (const Error& error) {
      const std::string& reason = error.detail.empty() ? error.message : error.detail;
      if (error.code == ErrorCode::kNotFound) return std::nullopt;
      if (error.code == ErrorCode::kStorage) {
        complain("bakes.read_failed", path, reason);
      } else {
        set_aside(path, reason);
      }
    }
  } catch (const std::exception& error) {  // out of memory: the bake may find less to do, or say so itself
    complain("bakes.read_failed", current_, error.what());
  }
  return std::nullopt;
}

bool BakeStore::save(const ContentHash& key, const StoredBake& bake) {
  if (budget_bytes_ <= 0) return false;
  bool saved = false;
  try {
    const fs::path path = path_of(key);
    const std::string file = encode_bake(key, bake);
    if (std::int64_t(file.size()) <= std::min(kLargestBakeFileBytes, budget_bytes_)) {
      fs::create_directories(current_);
      write_file_atomically(path, file);
      saved = true;
      trim();
    } else {
      complain("bakes.too_large", path,
               fmt::format("{} bytes of a budget of {}", file.size(), budget_bytes_));
    }
  } catch (const Error& error) {
    complain("bakes.write_failed", current_, error.detail.empty() ? error.message : error.detail);
  } catch (const std::exception& error) {
    complain("bakes.write_failed", current_, error.what());
  }
  ++(saved ? saved_ : refused_);
  return saved;
}

BakeStore::Stats BakeStore::stats() const {
  return {hits_, misses_, set_aside_, saved_, refused_, trimmed_};
}

void BakeStore::set_aside(const fs::path& path, std::string_view reason) {
  ++set_aside_;
  complain("bakes.damaged", path, reason);
  const fs::path damaged = current_ / "damaged" / path.filename().replace_extension(".bad");
  std::error_code error;
  fs::create_directories(damaged.parent_path(), error);
  fs::rename(path, damaged, error);
  if (error) {
    remove_file(path);
    return;
  }
  mark_used_now(damaged);
  trim_damaged();
}

void BakeStore::remove_abandoned() {
  for (const Listed& file : list_files(root_)) {
    if (file.kind != Kind::kUnfinished) continue;
    const bool is_old = FileTime::clock::now() - file.used > kAbandonedAfter;
    if (is_old || writer_has_ended(file.path)) remove_file(file.path);
  }
}

// Damaged files go before good ones, then what was used longest ago. Who else trims the same folder removes the same
// files: one that is gone already counts as removed.
void BakeStore::trim() {
  std::vector<Listed> files = list_files(root_);
  std::erase_if(files, [](const Listed& file) { return file.kind == Kind::kUnfinished; });
  std::ranges::sort(files, {}, [](const Listed& file) {
    return std::tuple(file.kind != Kind::kDamaged, file.used, file.path.filename());
  });
  std::int64_t sum = 0;
  for (const Listed& file : files) sum += file.bytes;
  for (const Listed& file : files) {
    if (sum <= budget_bytes_) return;
    trimmed_ += remove_file(file.path);
    sum -= file.bytes;
  }
}

void BakeStore::trim_damaged() {
  std::vector<Listed> files = list_files(current_ / "damaged");
  std::ranges::sort(files, std::ranges::greater(), &Listed::used);
  for (std::size_t i = kDamagedKept; i < files.size(); ++i) remove_file(files[i].path);
}

void BakeStore::complain(std::string_view event, const fs::path& path, std::string_view reason) {
  std::int64_t unsaid = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    const auto [entry, is_first] = complaints_.try_emplace(event, Complaint{now, 0});
    Complaint& complaint = entry->second;
    if (!is_first && now - complaint.last < kQuiet) {
      ++complaint.unsaid;
      return;
    }
    complaint.last = now;
    unsaid = std::exchange(complaint.unsaid, 0);
  }
  log::warning(event, {{"path", path.string()}, {"reason", reason}, {"unsaid", unsaid}});
}

}  // namespace furnace
