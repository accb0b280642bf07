#include "renderer/image/basis_bits.hpp"

#include "renderer/image/codecs.hpp"

#include <algorithm>
#include <array>

namespace furnace {

namespace {

constexpr unsigned kLongest = 16;

[[noreturn]] void fail_code() {
  fail_damaged("KTX2", "a Huffman code in it");
}

std::uint32_t reversed(std::uint32_t code, unsigned length) {
  std::uint32_t result = 0;
  for (unsigned i = 0; i < length; ++i) result |= (code >> i & 1) << (length - 1 - i);
  return result;
}

}  // namespace

HuffmanTable::HuffmanTable(std::span<const std::uint8_t> code_lengths) {
  std::array<std::uint32_t, kLongest + 2> next{};
  for (const std::uint8_t length : code_lengths) {
    if (length > kLongest) fail_code();
    if (length > 0) ++next[length + 1u];
    longest_ = std::max<unsigned>(longest_, length);
  }
  // The first code of each length; `next[n + 1]` counted those of length n.
  std::uint32_t code = 0;
  for (unsigned length = 1; length <= kLongest; ++length) {
    code = (code + next[length]) << 1;
    if (code + next[length + 1u] > 1u << length) fail_code();
    next[length] = code;
  }
  entries_.assign(std::size_t{1} << longest_, Entry{});
  for (std::size_t symbol = 0; symbol < code_lengths.size(); ++symbol) {
    const unsigned length = code_lengths[symbol];
    if (length == 0) continue;
    for (std::size_t at = reversed(next[length]++, length); at < entries_.size();
         at += std::size_t{1} << length)
      entries_[at] = {std::uint16_t(symbol), std::uint8_t(length)};
  }
}

std::uint32_t HuffmanTable::read(LsbBits& bits) const {
  const Entry entry = entries_[bits.peek(longest_)];
  if (entry.length == 0) fail_code();
  bits.skip(entry.length);
  if (bits.overrun()) fail_damaged("KTX2", "it ends early");
  return entry.symbol;
}

HuffmanTable read_huffman_table(LsbBits& bits) {
  constexpr std::array<std::uint8_t, 21> kOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
  constexpr std::uint32_t kShortZeros = 17, kLongZeros = 18, kShortRepeat = 19;
  const std::size_t symbols = bits.take(14);
  if (symbols == 0) return {};
  const std::size_t codes = bits.take(5);
  if (codes < 1 || codes > kOrder.size()) fail_code();
  std::array<std::uint8_t, kOrder.size()> sizes{};
  for (std::size_t i = 0; i < codes; ++i) sizes[kOrder[i]] = std::uint8_t(bits.take(3));
  const HuffmanTable lengths_code(sizes);

  std::vector<std::uint8_t> lengths;
  while (lengths.size() < symbols) {
    const std::uint32_t symbol = lengths_code.read(bits);
    if (symbol < kShortZeros) {
      lengths.push_back(std::uint8_t(symbol));
      continue;
    }
    const bool zeros = symbol <= kLongZeros;
    if (!zeros && (lengths.empty() || lengths.back() == 0)) fail_code();
    const std::size_t run = symbol == kShortZeros    ? 3 + bits.take(3)
                            : symbol == kLongZeros   ? 11 + bits.take(7)
                            : symbol == kShortRepeat ? 3 + bits.take(2)
                                                     : 7 + bits.take(7);
    if (run > symbols - lengths.size()) fail_code();
    lengths.insert(lengths.end(), run, zeros ? std::uint8_t(0) : lengths.back());
  }
  if (bits.overrun()) fail_damaged("KTX2", "it ends early");
  return HuffmanTable(lengths);
}

}  // namespace furnace
