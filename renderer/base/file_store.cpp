#include "renderer/base/file_store.hpp"

#include <algorithm>
#include <chrono>
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
// Other processes write to the same folder, so what this one has counted is counted anew now and then.
constexpr int kSavesBetweenCounts = 256;

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

std::string reason_of(const Error& error) {
  return error.detail.empty() ? error.message : error.detail;
}

}  // namespace

struct FileStore::Listed {
  fs::path path;
  Kind kind;
  FileTime used;
  std::int64_t bytes;
};

FileStore::FileStore(FileStoreConfig config)
    : config_(std::move(config)), current_(config_.folder / fmt::format("v{}", config_.version)) {
  if (config_.budget_bytes <= 0) return;
  try {
    remove_abandoned();
    trim();
  } catch (const std::exception& error) {
    complain("trim_failed", config_.folder, error.what());
  }
}

fs::path FileStore::path_of(const ContentHash& key) const {
  return current_ / fmt::format("{}.{}", key.hex(), config_.extension);
}

void FileStore::read(const ContentHash& key, const std::function<void(std::string)>& use) {
  try {
    const fs::path path = path_of(key);
    try {
      use(read_file(path, std::min(config_.largest_bytes, config_.budget_bytes)));
      mark_used_now(path);
    } catch (const Error& error) {
      if (error.code == ErrorCode::kNotFound) return;
      if (error.code == ErrorCode::kStorage) return complain("read_failed", path, reason_of(error));
      set_aside(path, reason_of(error));
    }
  } catch (
      const std::exception& error) {  // out of memory: what is missed may find less to do, or say so itself
    complain("read_failed", current_, error.what());
  }
}

bool FileStore::save(const ContentHash& key, const std::function<std::string()>& encode) {
  if (config_.budget_bytes <= 0) return false;
  bool saved = false;
  try {
    const fs::path path = path_of(key);
    const std::string file = encode();
    const auto bytes = std::int64_t(file.size());
    if (bytes <= std::min(config_.largest_bytes, config_.budget_bytes)) {
      fs::create_directories(current_);
      write_file_atomically(path, file);
      saved = true;
      const bool is_full = (counted_bytes_ += bytes) > config_.budget_bytes;
      if (is_full || ++saves_since_count_ >= kSavesBetweenCounts) trim();
    } else {
      complain("too_large", path, fmt::format("{} bytes of a budget of {}", bytes, config_.budget_bytes));
    }
  } catch (const Error& error) {
    complain("write_failed", current_, reason_of(error));
  } catch (const std::exception& error) {
    complain("write_failed", current_, error.what());
  }
  ++(saved ? saved_ : refused_);
  return saved;
}

bool FileStore::contains(const ContentHash& key) const {
  std::error_code error;
  return config_.budget_bytes > 0 && fs::exists(path_of(key), error);
}

FileStore::Stats FileStore::stats() const {
  return {hits_, misses_, set_aside_, saved_, refused_, trimmed_};
}

// Nothing but what this store names is ever removed. Unfinished is what write_file_atomically writes to:
// .KEY.EXTENSION.PID.SERIAL.tmp.
FileStore::Kind FileStore::kind_of(const fs::path& path) const {
  const std::string text = path.filename().string();
  std::string_view name = text;
  const bool is_hidden = name.starts_with('.');
  if (is_hidden) name.remove_prefix(1);
  constexpr std::size_t kKeyDigits = 2 * sizeof(ContentHash::bytes);
  const std::string_view key = name.substr(0, kKeyDigits), rest = name.substr(key.size());
  if (key.size() != kKeyDigits || key.find_first_not_of("0123456789abcdef") != key.npos)
    return Kind::kForeign;
  const std::string own = fmt::format(".{}", config_.extension);
  if (is_hidden)
    return rest.starts_with(own + ".") && rest.ends_with(".tmp") ? Kind::kUnfinished : Kind::kForeign;
  return rest == own ? Kind::kKept : rest == ".bad" ? Kind::kDamaged : Kind::kForeign;
}

// What vanishes meanwhile is left out.
std::vector<FileStore::Listed> FileStore::list_files(const fs::path& root) const {
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

void FileStore::set_aside(const fs::path& path, std::string_view reason) {
  ++set_aside_;
  complain("damaged", path, reason);
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

void FileStore::remove_abandoned() {
  for (const Listed& file : list_files(config_.folder)) {
    if (file.kind != Kind::kUnfinished) continue;
    const bool is_old = FileTime::clock::now() - file.used > kAbandonedAfter;
    if (is_old || writer_has_ended(file.path)) remove_file(file.path);
  }
}

// Damaged files go before good ones, then what was used longest ago. Who else trims the same folder removes the same
// files: one that is gone already counts as removed.
void FileStore::trim() {
  std::vector<Listed> files = list_files(config_.folder);
  std::erase_if(files, [](const Listed& file) { return file.kind == Kind::kUnfinished; });
  std::ranges::sort(files, {}, [](const Listed& file) {
    return std::tuple(file.kind != Kind::kDamaged, file.used, file.path.filename());
  });
  std::int64_t sum = 0;
  for (const Listed& file : files) sum += file.bytes;
  for (const Listed& file : files) {
    if (sum <= config_.budget_bytes) break;
    trimmed_ += remove_file(file.path);
    sum -= file.bytes;
  }
  counted_bytes_ = sum;
  saves_since_count_ = 0;
}

void FileStore::trim_damaged() {
  std::vector<Listed> files = list_files(current_ / "damaged");
  std::ranges::sort(files, std::ranges::greater(), &Listed::used);
  for (std::size_t i = kDamagedKept; i < files.size(); ++i) remove_file(files[i].path);
}

void FileStore::complain(std::string_view event, const fs::path& path, std::string_view reason) {
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
  log::warning(fmt::format("{}.{}", config_.name, event),
               {{"path", path.string()}, {"reason", reason}, {"unsaid", unsaid}});
}

}  // namespace furnace
