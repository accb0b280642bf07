// Bytes of what other programs wrote, as tests hold them.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace furnace::test {

// Two digits a byte. Errors: std::invalid_argument, anything else.
inline std::vector<std::uint8_t> bytes_of_hex(std::string_view text) {
  std::vector<std::uint8_t> bytes(text.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char *const begin = &text[2 * i], *const end = begin + 2;
    if (std::from_chars(begin, end, bytes[i], 16).ptr != end) throw std::invalid_argument("no hex digits");
  }
  if (text.size() % 2 != 0) throw std::invalid_argument("half a byte");
  return bytes;
}

}  // namespace furnace::test
