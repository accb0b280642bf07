#include "server/upload_file.hpp"

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".part";

[[noreturn]] void fail_storage(const fs::path& path, std::string_view what, const std::error_code& why) {
  fail(ErrorCode::kStorage, fmt::format("The server's disk refused the upload: {}.", why.message()), {},
       fmt::format("{} {}: {}", path.string(), what, why.message()));
}

std::error_code last_error() {
  return {errno, std::generic_category()};
}

// False when somebody has taken the file for abandoned between its making and its lock. Where locks are unknown, none holds.
bool lock(int file) {
  struct stat status {};
  const bool is_taken = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  return !is_taken && ::fstat(file, &status) == 0 && status.st_nlink > 0;
}

void make_durable(const fs::path& folder) {
  const Descriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!directory.is_open() || ::fsync(directory.get()) != 0) fail_storage(folder, "sync", last_error());
}

void make_folder(const fs::path& folder) {
  std::error_code wrong;
  const bool is_new = fs::create_directories(folder, wrong);
  if (wrong) fail_storage(folder, "make", wrong);
  if (is_new) make_durable(folder.parent_path());
}

}  // namespace

UploadFile::UploadFile(const fs::path& folder) {
  static std::atomic<unsigned> serial{0};
  make_folder(folder);
  constexpr int kTries = 1000;  // a name may be taken by a process of the same number in another container
  for (int i = 0; i < kTries; ++i) {
    path_ = folder / fmt::format("{}-{}{}", ::getpid(), ++serial, kEnding);
    file_ = Descriptor(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
    if (!file_.is_open() && errno != EEXIST) fail_storage(path_, "create", last_error());
    if (file_.is_open() && lock(file_.get())) return;
    file_.close();
  }
  fail_storage(path_, "create", std::make_error_code(std::errc::file_exists));
}

UploadFile UploadFile::resume(const fs::path& path) {
  make_folder(path.parent_path());
  UploadFile upload;
  constexpr int kTries = 100;  // it may be published or removed between its opening and its lock
  for (int i = 0; i < kTries; ++i) {
    Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644));
    if (!file.is_open()) fail_storage(path, "open", last_error());
    if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return upload;
    struct stat opened {
    }, named{};
    const bool is_it = ::fstat(file.get(), &opened) == 0 && ::lstat(path.c_str(), &named) == 0 &&
                       opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
    if (!is_it) continue;
    upload.path_ = path;
    upload.file_ = std::move(file);
    upload.stays_ = true;
    return upload;
  }
  return upload;
}

UploadFile::~UploadFile() {
  if (!stays_) remove();
}

UploadFile::UploadFile(UploadFile&& other) noexcept
    : path_(std::exchange(other.path_, {})), file_(std::move(other.file_)), stays_(other.stays_) {}

UploadFile& UploadFile::operator=(UploadFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  std::swap(stays_, other.stays_);
  return *this;
}

void UploadFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_storage(path_, "write", last_error());
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::int64_t UploadFile::size() const {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) fail_storage(path_, "look at", last_error());
  return status.st_size;
}

void UploadFile::publish(const fs::path& path) {
  make_folder(path.parent_path());
  if (::fsync(file_.get()) != 0) fail_storage(path_, "sync", last_error());
  if (::rename(path_.c_str(), path.c_str()) != 0) fail_storage(path, "rename", last_error());
  path_.clear();
  if (!file_.close()) fail_storage(path, "close", last_error());
  make_durable(path.parent_path());
}

void UploadFile::remove() {
  if (!path_.empty() && file_.is_open()) ::unlink(path_.c_str());
  path_.clear();
  file_.close();
}

void UploadFile::remove_abandoned(const fs::path& folder) {
  std::error_code wrong;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, wrong)) {
    if (entry.path().extension() != kEnding) continue;
    const Descriptor file(::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    if (file.is_open() && ::flock(file.get(), LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
  }
}

}  // namespace furnace
