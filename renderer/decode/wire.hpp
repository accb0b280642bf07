// Values as bytes for a process that is not trusted. One description of a type's fields serves both directions:
//   template <class Wire> void fields(Wire& wire, WireValue<Wire, Extent>& extent) { wire.number(extent.width); ... }
// Numbers are little-endian, as wide as their type; large arrays go through a block of shared memory.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace furnace::decode {

static_assert(std::endian::native == std::endian::little, "the wire is written by memcpy");

template <class Wire, class Value>
using WireValue = std::conditional_t<Wire::kReads, Value, const Value>;

// Threads: one. Owns: the small values; arrays go to `block`.
class WireWriter {
 public:
  static constexpr bool kReads = false;

  explicit WireWriter(std::span<std::byte> block = {}) : block_(block) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void number(const Number& value) { append(&value, sizeof value); }
  // An enumerator of 0 .. `last`.
  template <class Enum>
  void choice(const Enum& value, Enum) {
    number(static_cast<std::uint8_t>(value));
  }
  // Cut off at `most_bytes`.
  void text(const std::string& value, std::size_t most_bytes);
  template <class Element>
  requires std::is_trivially_copyable_v<Element>
  void array(const std::vector<Element>& values) {
    number(std::uint64_t(values.size()));
    put_in_block(std::as_bytes(std::span(values)));
  }
  // Few values, at most `most`; `each` writes one.
  template <class Value, class Each>
  void list(const std::vector<Value>& values, std::size_t most, Each&& each) {
    fits_ = fits_ && values.size() <= most;
    number(std::uint32_t(values.size()));
    for (const Value& value : values) each(value);
  }

  bool fits() const { return fits_; }  // whether the arrays and lists did
  const std::string& bytes() const { return bytes_; }

 private:
  void append(const void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }
  void put_in_block(std::span<const std::byte> bytes);

  std::span<std::byte> block_;
  std::string bytes_;
  std::size_t block_used_ = 0;
  bool fits_ = true;
};

// Everything read may be a lie: numbers may have any value, but no text, array or list is longer than told, no enumerator is out
// of range. After the first fault all that is read is zero or empty.
// Threads: one. Owns: nothing; `bytes` and the memory behind `block_fd` outlive it.
class WireReader {
 public:
  static constexpr bool kReads = true;

  // The block is copied out, never mapped: its writer may still change it.
  explicit WireReader(std::string_view bytes, int block_fd = -1, std::size_t block_bytes = 0)
      : bytes_(bytes), block_fd_(block_fd), block_bytes_(block_bytes) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void number(Number& value) {
    value = {};
    if (const char* from = take(sizeof value)) std::memcpy(&value, from, sizeof value);
  }
  template <class Enum>
  void choice(Enum& value, Enum last) {
    std::uint8_t said = 0;
    number(said);
    if (said > static_cast<std::uint8_t>(last)) sound_ = false;
    value = sound_ ? static_cast<Enum>(said) : Enum{};
  }
  void text(std::string& value, std::size_t most_bytes);
  template <class Element>
  requires std::is_trivially_copyable_v<Element>
  void array(std::vector<Element>& values) {
    const std::size_t count = array_count(sizeof(Element));
    values.reserve(count);
    expect_large(std::as_writable_bytes(std::span(values.data(), count)));
    values.resize(count);
    get_from_block(std::as_writable_bytes(std::span(values)));
  }
  template <class Value, class Each>
  void list(std::vector<Value>& values, std::size_t most, Each&& each) {
    std::uint32_t count = 0;
    number(count);
    sound_ = sound_ && count <= most;
    values.clear();
    for (std::uint32_t i = 0; i < count && sound_; ++i) each(values.emplace_back());
  }

  // Whether all was there and nothing is left.
  bool ended_well() const { return sound_ && bytes_.empty(); }

 private:
  const char* take(std::size_t size);  // null: not so many are left
  std::size_t array_count(std::size_t element_bytes);
  static void expect_large(std::span<std::byte> memory);
  void get_from_block(std::span<std::byte> bytes);

  std::string_view bytes_;
  int block_fd_;
  std::size_t block_bytes_;
  std::size_t block_used_ = 0;
  bool sound_ = true;
};

}  // namespace furnace::decode
