// Whole files in and out. Nothing here follows a request's path: callers have decided what may be opened.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace furnace {

// Tells two states of a file apart without reading it.
struct FileIdentity {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::int64_t size_bytes = 0;
  std::int64_t modified_ns = 0;  // since the epoch

  auto operator<=>(const FileIdentity&) const = default;
};

// Of a regular file (symbolic links followed); none when there is no such file.
std::optional<FileIdentity> file_identity(const std::filesystem::path& path);

// Errors: kNotFound (missing, or not a regular file), kTooLarge, kStorage. Messages name the file, `detail`
// its whole path.
std::string read_file(const std::filesystem::path& path, std::int64_t max_bytes);

// After a crash there is the old file or the new one, never a part: temporary file in the same folder, fsync,
// rename, fsync of the folder. What is there and no regular file, a device, a pipe or a link, stays, and the bytes go
// through it without that promise; a pipe is waited for. Errors: kStorage.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace furnace
