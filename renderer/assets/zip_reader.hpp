// ZIP archives from strangers (PKWARE APPNOTE 6.3.10): stored and deflated files, nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/base/blob.hpp"

namespace furnace {

struct ZipLimits {
  int max_entries = 1000;                    // folders counted
  std::int64_t max_total_bytes = 1ll << 30;  // of all files, inflated
  std::int64_t max_ratio = 100;              // of all files inflated to the archive
  std::int64_t free_bytes = 16 << 20;        // of all files inflated, whatever the ratio
};

// By its first bytes.
bool is_zip(std::span<const std::byte> file);

// Threads: any, once built. Owns: a share of the archive's bytes.
class ZipReader {
 public:
  // Reads the directory; inflates nothing. Errors: kTooLarge over a limit; kUnprocessable for whatever is broken, encrypted,
  // split, a link, in ZIP64, or of a name that is given twice, absolute or climbs.
  explicit ZipReader(Blob archive, const ZipLimits& limits = {});

  std::vector<std::string> names() const;  // of files, '/' between folders; sorted
  // None: there is no such file. Errors: kUnprocessable when it is damaged.
  std::optional<Blob> read(const std::string& name) const;

 private:
  struct Entry {
    std::uint32_t method = 0, crc = 0;
    std::size_t packed_bytes = 0, bytes = 0;
    std::size_t offset = 0;  // of its local header
  };
  std::size_t add_entry(std::size_t at, std::size_t end);
  std::span<const std::byte> packed(const std::string& name, const Entry& entry) const;

  Blob archive_;
  std::map<std::string, Entry> files_;
};

// The model that an archive is: the only file of a model's ending at the shallowest depth that has one; hidden files and
// what macOS adds do not count. Errors: kUnprocessable when there is none, or more than one, which are listed.
std::string model_in(const ZipReader& archive);

}  // namespace furnace
