// The appendix "Bitstream" of KHR_meshopt_compression. Debian's library reads version 0 only.
#include "renderer/scene/meshopt_attributes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace furnace {

namespace {

constexpr std::size_t kGroup = 16, kMostBlock = 256, kBlockBytes = 8192, kChannel = 4;

enum Control : unsigned { kLowBits, kHighBits, kZeros, kLiteral };  // of one byte of the elements, in a block
enum Deltas : unsigned { kOfBytes, kOfWords, kOfBits };             // of one channel, four bytes

class Input {
 public:
  explicit Input(std::span<const std::byte> bytes) : left_(bytes) {}

  std::size_t size() const { return left_.size(); }
  bool take(std::size_t count, std::span<const std::byte>& out) {
    if (count > left_.size()) return false;
    out = left_.first(count);
    left_ = left_.subspan(count);
    return true;
  }
  bool take(std::uint8_t& out) {
    if (left_.empty()) return false;
    out = std::to_integer<std::uint8_t>(left_[0]);
    left_ = left_.subspan(1);
    return true;
  }

 private:
  std::span<const std::byte> left_;
};

// 16 deltas of `bits` each; one with all bits set stands for a whole byte after them.
bool read_group(Input& input, unsigned bits, std::uint8_t* out) {
  if (bits == 0) {
    std::fill_n(out, kGroup, std::uint8_t(0));
    return true;
  }
  std::span<const std::byte> packed;
  if (!input.take(kGroup * bits / 8, packed)) return false;
  if (bits == 8) {
    std::memcpy(out, packed.data(), kGroup);
    return true;
  }
  const unsigned sentinel = (1u << bits) - 1, per_byte = 8 / bits;
  for (unsigned i = 0; i < kGroup; ++i) {
    const unsigned place = i % per_byte;
    // Single bits are packed from the lowest, others from the highest.
    const unsigned shift = bits == 1 ? place : (per_byte - 1 - place) * bits;
    out[i] = std::uint8_t(std::to_integer<unsigned>(packed[i / per_byte]) >> shift & sentinel);
    if (out[i] == sentinel && !input.take(out[i])) return false;
  }
  return true;
}

// The deltas of one byte of `count` elements. `widths`: bits of a delta by the two bits of a group's header.
bool read_groups(Input& input, const std::array<std::uint8_t, 4>& widths, std::size_t count,
                 std::uint8_t* out) {
  const std::size_t groups = (count + kGroup - 1) / kGroup;
  std::span<const std::byte> header;
  if (!input.take((groups + 3) / 4, header)) return false;
  for (std::size_t g = 0; g < groups; ++g) {
    const unsigned mode = std::to_integer<unsigned>(header[g / 4]) >> (g % 4 * 2) & 3;
    if (!read_group(input, widths[mode], out + g * kGroup)) return false;
  }
  return true;
}

bool read_deltas(Input& input, unsigned control, std::size_t count, std::uint8_t* out) {
  switch (control) {
    case kLowBits:
      return read_groups(input, {0, 1, 2, 4}, count, out);
    case kHighBits:
      return read_groups(input, {1, 2, 4, 8}, count, out);
    case kZeros:
      std::fill_n(out, count, std::uint8_t(0));
      return true;
    default: {
      std::span<const std::byte> literal;
      if (!input.take(count, literal)) return false;
      std::memcpy(out, literal.data(), count);
      return true;
    }
  }
}

template <class T>
T unzigzag(T v) {
  return T((v & 1) != 0 ? ~(v >> 1) : v >> 1);
}

// By byte: the deltas of a block.
using ChannelDeltas = std::array<std::array<std::uint8_t, kMostBlock>, kChannel>;

std::uint32_t word_of(const ChannelDeltas& deltas, std::size_t i) {
  return deltas[0][i] | std::uint32_t(deltas[1][i]) << 8 | std::uint32_t(deltas[2][i]) << 16 |
         std::uint32_t(deltas[3][i]) << 24;
}

// One channel's value after another's, in one 32-bit word.
std::uint32_t next_value(std::uint32_t last, std::uint32_t delta, unsigned deltas, unsigned rotation) {
  if (deltas == kOfBits) return last ^ std::rotr(delta, int(rotation));
  std::uint32_t value = 0;
  if (deltas == kOfWords) {
    for (unsigned shift = 0; shift < 32; shift += 16) {
      value |= std::uint32_t(std::uint16_t((last >> shift) + unzigzag(std::uint16_t(delta >> shift))))
               << shift;
    }
    return value;
  }
  for (unsigned shift = 0; shift < 32; shift += 8) {
    value |= std::uint32_t(std::uint8_t((last >> shift) + unzigzag(std::uint8_t(delta >> shift)))) << shift;
  }
  return value;
}

std::uint32_t load_word(const std::byte* bytes) {
  std::uint32_t word = 0;
  for (unsigned i = 0; i < 4; ++i) word |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
  return word;
}

void store_word(std::byte* bytes, std::uint32_t word) {
  for (unsigned i = 0; i < 4; ++i) bytes[i] = std::byte(word >> (8 * i));
}

// Threads: one. Owns: the element before the next.
class Decoder {
 public:
  Decoder(std::size_t stride, int version) : stride_(stride), version_(version) {}

  // The baseline element, and each channel's way of deltas.
  bool start(std::span<const std::byte> tail) {
    std::copy_n(tail.begin(), stride_, last_.begin());
    for (std::size_t c = 0; version_ == 1 && c < stride_ / kChannel; ++c) {
      const auto mode = std::to_integer<std::uint8_t>(tail[stride_ + c]);
      if ((mode & 15) > kOfBits || ((mode & 15) != kOfBits && mode >> 4 != 0)) return false;
      modes_[c] = mode;
    }
    return true;
  }

  bool block(Input& input, std::span<std::byte> target) {
    const std::size_t count = target.size() / stride_;
    std::span<const std::byte> controls;
    if (version_ == 1 && !input.take(stride_ / kChannel, controls)) return false;
    ChannelDeltas deltas;
    for (std::size_t c = 0; c < stride_ / kChannel; ++c) {
      for (std::size_t k = 0; k < kChannel; ++k) {
        const bool sound = version_ == 1
                               ? read_deltas(input, std::to_integer<unsigned>(controls[c]) >> (2 * k) & 3,
                                             count, deltas[k].data())
                               : read_groups(input, {0, 2, 4, 8}, count, deltas[k].data());
        if (!sound) return false;
      }
      std::uint32_t value = load_word(&last_[c * kChannel]);
      for (std::size_t i = 0; i < count; ++i) {
        value = next_value(value, word_of(deltas, i), modes_[c] & 15u, modes_[c] >> 4);
        store_word(&target[i * stride_ + c * kChannel], value);
      }
      store_word(&last_[c * kChannel], value);
    }
    return true;
  }

 private:
  const std::size_t stride_;
  const int version_;
  std::array<std::byte, 256> last_{};
  std::array<std::uint8_t, 64> modes_{};
};

}  // namespace

bool decode_meshopt_attributes(std::span<const std::byte> bytes, std::size_t stride,
                               std::span<std::byte> target) {
  Input input(bytes);
  std::uint8_t header = 0;
  if (!input.take(header) || (header != 0xa0 && header != 0xa1)) return false;
  const int version = header & 1;
  const std::size_t tail = version == 1 ? stride + stride / kChannel : stride;
  const std::size_t tail_area = std::max<std::size_t>(tail, version == 1 ? 24 : 32);
  if (input.size() < tail_area) return false;
  Decoder decoder(stride, version);
  if (!decoder.start(bytes.last(tail))) return false;

  Input blocks(bytes.subspan(1, input.size() - tail_area));
  const std::size_t block = std::min(kBlockBytes / stride & ~(kGroup - 1), kMostBlock) * stride;
  for (std::size_t at = 0; at < target.size(); at += block) {
    if (!decoder.block(blocks, target.subspan(at, std::min(block, target.size() - at)))) return false;
  }
  return blocks.size() == 0;
}

}  // namespace furnace
