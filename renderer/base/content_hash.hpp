// SHA-256 of bytes and of canonical keys. Every cache key and ETag is one of these.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace furnace {

struct ContentHash {
  std::array<std::uint8_t, 32> bytes{};

  auto operator<=>(const ContentHash&) const = default;
  std::string hex() const;  // 64 lower-case digits
};

ContentHash hash_bytes(std::span<const std::byte> bytes);

// Builds a key from typed fields; every field is length-prefixed, so ("ab","c") differs from ("a","bc").
// Threads: one. Owns: its digest context.
class HashBuilder {
 public:
  HashBuilder();
  ~HashBuilder();
  HashBuilder(const HashBuilder&) = delete;
  HashBuilder& operator=(const HashBuilder&) = delete;

  HashBuilder& add(std::string_view text);
  HashBuilder& add(std::span<const std::byte> bytes);
  HashBuilder& add(std::int64_t value);
  HashBuilder& add(double value);  // by bits; -0.0 and 0.0 are one value, all NaNs are one value
  HashBuilder& add(const ContentHash& hash);
  ContentHash finish();  // once

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace furnace

template <>
struct std::hash<furnace::ContentHash> {
  std::size_t operator()(const furnace::ContentHash& hash) const noexcept;
};
