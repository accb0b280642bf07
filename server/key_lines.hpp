// Files of keys: a key a line, fields with ":" between, "#" comments.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct KeyLine {
  std::string place;                     // "line 3"
  std::vector<std::string_view> fields;  // into the text
};
std::vector<KeyLine> key_lines(std::string_view text);  // empty lines and comments left out

// Names go into logs, URLs and metrics.
inline constexpr std::string_view kKeyNameForm =
    "its name is not 1 to 64 letters, digits, dots, hyphens and underscores";
bool is_key_name(std::string_view name);

std::optional<std::string> bytes_of_hex(std::string_view digits);  // of either case
std::string hex_of_bytes(std::string_view bytes);

// The whole of a file of keys. Errors: those of read_file; kUnprocessable when it holds `secrets` and others than its owner
// and group may read it.
std::string read_key_file(const std::filesystem::path& path, bool secrets);

}  // namespace furnace
