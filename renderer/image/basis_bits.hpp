// Bits from the lowest of each byte on, and the Huffman codes of BasisLZ over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace furnace {

// Threads: one. Owns: nothing. Beyond the end there are zeros, and `overrun` tells.
class LsbBits {
 public:
  explicit LsbBits(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint32_t peek(unsigned count) const {  // at most 25
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t byte = place_ / 8 + i;
      if (byte < bytes_.size()) word |= std::to_integer<std::uint32_t>(bytes_[byte]) << (8 * i);
    }
    return word >> place_ % 8 & ((1u << count) - 1);
  }
  std::uint32_t take(unsigned count) {
    const std::uint32_t value = peek(count);
    place_ += count;
    return value;
  }
  void skip(unsigned count) { place_ += count; }
  bool overrun() const { return place_ > 8 * bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t place_ = 0;
};

// A canonical code as Deflate's (RFC 1951, section 3.2.2), of at most 16 bits.
class HuffmanTable {
 public:
  // No symbols. Reading one fails.
  HuffmanTable() = default;
  // By symbol; 0: it does not occur. Errors: kUnprocessable for more codes than fit.
  explicit HuffmanTable(std::span<const std::uint8_t> code_lengths);

  // Errors: kUnprocessable for bits that are no code, and at the stream's end.
  std::uint32_t read(LsbBits& bits) const;

 private:
  struct Entry {
    std::uint16_t symbol = 0;
    std::uint8_t length = 0;  // 0: no code
  };

  std::vector<Entry> entries_{1};  // by the next `longest_` bits
  unsigned longest_ = 0;
};

// KTX 2.0, BasisLZ bitstream, "Compressed Huffman Tables". Errors: kUnprocessable.
HuffmanTable read_huffman_table(LsbBits& bits);

}  // namespace furnace
