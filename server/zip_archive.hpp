// ZIP files in memory.
#pragma once

#include <string>
#include <vector>

namespace furnace {

struct ArchiveFile {
  std::string name;  // UTF-8, '/' between folders
  std::string bytes;
};

// The files as they are, in this order, without compression: pictures are compressed already. Same files, same bytes.
// Errors: kInternal. Threads: any.
std::string zip_archive(const std::vector<ArchiveFile>& files);

}  // namespace furnace
