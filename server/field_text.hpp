// Texts as header fields and settings have them: spaces round them, letters of either case.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace furnace {

inline std::string_view trimmed(std::string_view text, std::string_view spaces = " \t") {
  const std::size_t first = text.find_first_not_of(spaces);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(spaces) - first + 1);
}

inline std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return out;
}

}  // namespace furnace
