// SHA-256 of bytes that come piece by piece: the same as hash_bytes of all of them.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "renderer/base/content_hash.hpp"

namespace furnace {

// Threads: one. Owns: its digest context.
class ByteHasher {
 public:
  ByteHasher();
  ~ByteHasher();
  ByteHasher(const ByteHasher&) = delete;
  ByteHasher& operator=(const ByteHasher&) = delete;

  void add(std::span<const std::byte> bytes);
  ContentHash finish();  // once

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace furnace
