// What is fuzzed: a row for each parser of foreign bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace furnace::fuzz {

using Input = std::span<const std::byte>;

inline std::string_view text_of(Input input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

// As libFuzzer's LLVMFuzzerCustomMutator: changes `size` bytes in place, returns how many there are then, at most `room`.
using Mutate = std::size_t(std::uint8_t* data, std::size_t size, std::size_t room, unsigned seed);

struct Target {
  std::string_view name;
  // Returns or throws an Error, but not kInternal: anything else is a finding.
  void (*run)(Input input);
  std::size_t most_bytes;  // of an input
  Mutate* mutate;
};

std::span<const Target> image_targets();
std::span<const Target> gltf_targets();
std::span<const Target> mesh_targets();
std::span<const Target> request_targets();
std::span<const Target> url_targets();

// Takes fields off the front of an input; beyond its end there are zeros. Threads: one. Owns: nothing.
class Taker {
 public:
  explicit Taker(Input input) : rest_(input) {}

  std::uint32_t number(std::size_t bytes) {  // little-endian, at most 4 bytes
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes && !rest_.empty(); ++i, rest_ = rest_.subspan(1))
      value |= std::to_integer<std::uint32_t>(rest_[0]) << (8 * i);
    return value;
  }
  Input rest() const { return rest_; }

 private:
  Input rest_;
};

// Two texts in one input, with a zero byte between them; the second is empty without one.
struct TextPair {
  std::string_view first, second;
};
inline TextPair split(Input input) {
  const std::string_view whole = text_of(input);
  const std::size_t end = whole.find('\0');
  return {whole.substr(0, end), end == whole.npos ? std::string_view{} : whole.substr(end + 1)};
}

}  // namespace furnace::fuzz
