// Immutable bytes with their hash: what travels between the doors, the caches and the decoders.
#pragma once

#include "renderer/base/content_hash.hpp"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace furnace {

// Threads: any, immutable. Owns: a share of its bytes.
class Blob {
 public:
  Blob() = default;
  explicit Blob(std::string bytes);  // hashes once
  // A part of `whole` that keeps it alive (a buffer view of a GLB); the part is hashed.
  static Blob slice(const Blob& whole, std::size_t offset, std::size_t size);

  std::span<const std::byte> bytes() const { return bytes_; }
  operator std::span<const std::byte>() const { return bytes_; }  // codecs and hashes take plain bytes
  std::string_view text() const { return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}; }
  std::size_t size() const { return bytes_.size(); }
  bool empty() const { return bytes_.empty(); }
  const ContentHash& hash() const { return hash_; }

 private:
  std::shared_ptr<const void> owner_;
  std::span<const std::byte> bytes_;
  ContentHash hash_;
};

}  // namespace furnace
