// KTX2 files for tests, and bits in the order of Basis Universal.
#pragma once

#include "renderer/image/ktx2_container.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace furnace::sample {

struct Ktx2Parts {
  std::uint32_t vk_format = 37;  // R8G8B8A8_UNORM
  std::uint32_t width = 1, height = 1, depth = 0, layers = 0, faces = 1;
  std::uint32_t level_count = 1;  // as the header says; `levels` is what there is
  std::uint32_t scheme = 0;
  std::uint8_t model = 1, transfer = 1, flags = 0;
  std::vector<std::uint8_t> channels = {0};
  std::vector<std::pair<std::string, std::string>> metadata;
  std::string global_data;
  std::vector<std::string> levels;  // as stored, the largest first
};

inline void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i, value >>= 8) out.push_back(char(value));
}

inline std::string ktx2(const Ktx2Parts& parts) {
  std::string dfd;
  put(dfd, 28 + 16 * parts.channels.size(), 4);
  put(dfd, 0, 4);
  put(dfd, 2, 2);
  put(dfd, 24 + 16 * parts.channels.size(), 2);
  for (const std::uint8_t byte : {parts.model, std::uint8_t(1), parts.transfer, parts.flags})
    put(dfd, byte, 1);
  put(dfd, 0, 12);
  for (const std::uint8_t channel : parts.channels) {
    put(dfd, 0, 3);
    put(dfd, channel, 1);
    put(dfd, 0, 12);
  }
  std::string metadata;
  for (const auto& [key, value] : parts.metadata) {
    put(metadata, key.size() + value.size() + 2, 4);
    metadata += key + '\0' + value + '\0';
    metadata.resize((metadata.size() + 3) / 4 * 4);
  }
  std::string out("\xabKTX 20\xbb\r\n\x1a\n", 12);
  for (const std::uint32_t number : {parts.vk_format, 1u, parts.width, parts.height, parts.depth,
                                     parts.layers, parts.faces, parts.level_count, parts.scheme})
    put(out, number, 4);
  std::uint64_t at = 80 + 24 * parts.levels.size();
  for (const std::size_t size : {dfd.size(), metadata.size()}) {
    put(out, at, 4);
    put(out, size, 4);
    at += size;
  }
  put(out, at, 8);
  put(out, parts.global_data.size(), 8);
  at += parts.global_data.size();
  for (const std::string& level : parts.levels) {
    put(out, at, 8);
    put(out, level.size(), 8);
    put(out, level.size(), 8);
    at += level.size();
  }
  out += dfd + metadata + parts.global_data;
  for (const std::string& level : parts.levels) out += level;
  return out;
}

// The first bit is the lowest of its byte.
class BitWriter {
 public:
  void put(std::uint32_t value, unsigned count) {
    for (unsigned i = 0; i < count; ++i, ++size_) {
      if (size_ % 8 == 0) bytes_.push_back('\0');
      bytes_.back() = char(std::uint8_t(bytes_.back()) | (value >> i & 1) << size_ % 8);
    }
  }
  std::string take(std::size_t least_bytes = 0) {
    bytes_.resize(std::max(bytes_.size(), least_bytes), '\0');
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
  std::size_t size_ = 0;
};

}  // namespace furnace::sample
