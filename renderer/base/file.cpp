#include "renderer/base/file.hpp"

#include "renderer/base/descriptor.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <system_error>

namespace furnace {

namespace {

[[noreturn]] void fail_with_errno(ErrorCode code, const std::filesystem::path& path, const char* what,
                                  int error) {
  const std::string reason = std::generic_category().message(error);
  fail(code, fmt::format("file \"{}\" cannot be {}: {}", path.filename().string(), what, reason), {},
       fmt::format("{}: {}", path.string(), reason));
}

Descriptor open_file(const std::filesystem::path& path, int flags) {
  int fd = -1;
  do {
    fd = ::open(path.c_str(), flags | O_CLOEXEC, 0644);
  } while (fd < 0 && errno == EINTR);
  return Descriptor(fd);
}

// Removes the temporary file unless it was renamed.
struct TemporaryFile {
  std::filesystem::path path;
  bool renamed = false;

  ~TemporaryFile() {
    if (!renamed) ::unlink(path.c_str());
  }
};

void write_all(int fd, std::string_view bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_with_errno(ErrorCode::kStorage, path, "written", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

// Whether there is something that a renamed file must not replace.
bool is_special(const std::filesystem::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

void write_through(const std::filesystem::path& path, std::string_view bytes) {
  Descriptor file = open_file(path, O_WRONLY | O_TRUNC);
  if (!file.is_open()) fail_with_errno(ErrorCode::kStorage, path, "opened", errno);
  write_all(file.get(), bytes, path);
  if (!file.close()) fail_with_errno(ErrorCode::kStorage, path, "written", errno);
}

}  // namespace

std::optional<FileIdentity> file_identity(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return FileIdentity{status.st_dev, status.st_ino, status.st_size,
                      std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

std::string read_file(const std::filesystem::path& path, std::int64_t max_bytes) {
  const Descriptor file = open_file(path, O_RDONLY | O_NONBLOCK);  // a pipe without a writer must not stop us
  if (!file.is_open()) {
    const bool missing = errno == ENOENT || errno == ENOTDIR;
    fail_with_errno(missing ? ErrorCode::kNotFound : ErrorCode::kStorage, path, "opened", errno);
  }
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail_with_errno(ErrorCode::kStorage, path, "examined", errno);
  if (!S_ISREG(status.st_mode)) {
    fail(ErrorCode::kNotFound, fmt::format("\"{}\" is not a regular file", path.filename().string()), {},
         path.string());
  }
  const auto refuse_size = [&] {
    fail(ErrorCode::kTooLarge,
         fmt::format("file \"{}\" is larger than {} bytes", path.filename().string(), max_bytes), {},
         path.string());
  };
  if (status.st_size > max_bytes) refuse_size();

  // One byte more than it should have, to meet the end without another growth; it may also have changed
  // meanwhile.
  std::string bytes(static_cast<std::size_t>(status.st_size) + 1, '\0');
  std::size_t size = 0;
  for (;;) {
    if (size == bytes.size()) bytes.resize(2 * size);
    const ssize_t got = ::read(file.get(), bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_with_errno(ErrorCode::kStorage, path, "read", errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (static_cast<std::int64_t>(size) > max_bytes) refuse_size();
  }
  bytes.resize(size);
  return bytes;
}

void write_file_atomically(const std::filesystem::path& path, std::string_view bytes) {
  if (is_special(path)) return write_through(path, bytes);
  static std::atomic<unsigned> serial{0};
  const std::filesystem::path folder =
      path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  // A name may be taken: by what a killed process left, or by a process with the same id in another container.
  constexpr int kTries = 1000;
  TemporaryFile temporary;
  Descriptor file;
  for (int i = 0; i < kTries && !file.is_open() && (i == 0 || errno == EEXIST); ++i) {
    temporary.path = folder / fmt::format(".{}.{}.{}.tmp", path.filename().string(), ::getpid(), ++serial);
    file = open_file(temporary.path, O_WRONLY | O_CREAT | O_EXCL);
  }
  if (!file.is_open()) {
    const int error = errno;
    temporary.renamed = true;  // it is not ours
    fail_with_errno(ErrorCode::kStorage, path, "created", error);
  }
  write_all(file.get(), bytes, path);
  if (::fsync(file.get()) != 0 || !file.close()) fail_with_errno(ErrorCode::kStorage, path, "written", errno);
  if (::rename(temporary.path.c_str(), path.c_str()) != 0) {
    fail_with_errno(ErrorCode::kStorage, path, "replaced", errno);
  }
  temporary.renamed = true;

  const Descriptor directory = open_file(folder, O_RDONLY | O_DIRECTORY);
  if (!directory.is_open() || ::fsync(directory.get()) != 0) {
    fail_with_errno(ErrorCode::kStorage, path, "made durable", errno);
  }
}

}  // namespace furnace
