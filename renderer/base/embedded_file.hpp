// A text file inside the binary; shaders/embed.cmake generates the tables.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace furnace {

struct EmbeddedFile {
  std::string_view path;  // relative to the BASE given to furnace_embed, with '/'
  std::string_view text;  // exact bytes, alive as long as the process
};

inline std::optional<std::string_view> embedded_file(std::span<const EmbeddedFile> files,
                                                     std::string_view path) {
  for (const EmbeddedFile& file : files)
    if (file.path == path) return file.text;
  return std::nullopt;
}

}  // namespace furnace
