// Bytes of what other programs wrote, as tests hold them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace furnace::test {

// Two digits a byte; anything but digits throws.
inline std::vector<std::uint8_t> bytes_of_hex(std::string_view text) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < text.size(); i += 2)
    bytes.push_back(std::uint8_t(std::stoul(std::string(text.substr(i, 2)), nullptr, 16)));
  return bytes;
}

}  // namespace furnace::test
