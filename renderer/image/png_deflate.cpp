#include "renderer/image/png_deflate.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

namespace furnace {

namespace {

constexpr std::size_t kBlockBytes = 96 << 10;  // one set of codes for about thirty rows of a typical render
constexpr std::size_t kEndOfBlock = 256;
constexpr std::size_t kLiteralCodes = 286;
constexpr int kLongestCode = 12;         // four of them and a rest of seven bits fit into 64
constexpr std::size_t kShortestRun = 8;  // zeros are cheap as literals: shorter runs make the file larger
constexpr std::size_t kLongestMatch = 258;

// RFC 1951, 3.2.5: length code, extra bits and their value of a match length.
struct LengthCode {
  std::uint16_t symbol;
  std::uint8_t extra_bits;
  std::uint8_t extra;
};

constexpr std::array<LengthCode, kLongestMatch + 1> kLengthCodes = [] {
  std::array<LengthCode, kLongestMatch + 1> codes{};
  std::size_t length = 3;
  for (std::uint16_t symbol = 257; symbol < 285; ++symbol) {
    const int extra_bits = symbol < 265 ? 0 : (symbol - 261) / 4;
    for (int extra = 0; extra < 1 << extra_bits && length < kLongestMatch; ++extra, ++length) {
      codes[length] = {symbol, static_cast<std::uint8_t>(extra_bits), static_cast<std::uint8_t>(extra)};
    }
  }
  codes[kLongestMatch] = {285, 0, 0};
  return codes;
}();

class BitWriter {
 public:
  // `out` must have room for all that is put.
  explicit BitWriter(std::uint8_t* out) : at_(out) {}

  // At most 56 bits between two flushes.
  void put(std::uint64_t value, int bits) {
    pending_ |= value << count_;
    count_ += bits;
  }

  void flush() {
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(at_, &pending_, 8);
    at_ += count_ / 8;
    pending_ >>= count_ & ~7;
    count_ &= 7;
  }

  void align() {
    count_ = (count_ + 7) & ~7;
    flush();
  }

  std::uint8_t* at() const { return at_; }
  void move_to(std::uint8_t* out) { at_ = out; }

 private:
  std::uint8_t* at_;
  std::uint64_t pending_ = 0;
  int count_ = 0;
};

// Huffman 1952, "A method for the construction of minimum-redundancy codes": how many symbols have a code of each length, for
// counts in rising order. Merged nodes come out in rising order too, so two queues do.
std::array<int, 64> depths_of(const std::vector<std::uint32_t>& counts) {
  const std::size_t leaves = counts.size();
  std::vector<std::uint64_t> weight(counts.begin(), counts.end());
  std::vector<std::size_t> parent(2 * leaves, 0);
  std::size_t leaf = 0, merged = leaves;
  const auto lightest = [&] {
    const bool is_leaf = leaf < leaves && (merged == weight.size() || weight[leaf] <= weight[merged]);
    return is_leaf ? leaf++ : merged++;
  };
  while (weight.size() < 2 * leaves - 1) {
    const std::size_t a = lightest(), b = lightest();
    parent[a] = parent[b] = weight.size();
    weight.push_back(weight[a] + weight[b]);
  }
  std::array<int, 64> symbols_of_depth{};
  std::vector<int> depth(weight.size(), 0);
  for (std::size_t node = weight.size() - 1; node-- > 0;) {
    depth[node] = depth[parent[node]] + 1;
    if (node < leaves) ++symbols_of_depth[static_cast<std::size_t>(depth[node])];
  }
  return symbols_of_depth;
}

// Makes the codes at most `limit` long; a code is made one bit longer for each that has become too short for the rest
// (Kraft's sum over 2^limit).
void shorten(std::array<int, 64>& symbols_of_depth, int limit) {
  const auto at = [&](int depth) -> int& { return symbols_of_depth[static_cast<std::size_t>(depth)]; };
  for (int depth = 63; depth > limit; --depth) at(limit) += std::exchange(at(depth), 0);
  int sum = 0;
  for (int depth = 1; depth <= limit; ++depth) sum += at(depth) << (limit - depth);
  for (; sum > 1 << limit; --sum) {
    int depth = limit - 1;
    while (at(depth) == 0) --depth;
    --at(depth);
    --at(limit);
    at(depth + 1) += 2;
  }
}

template <std::size_t Size>
struct Codes {
  std::array<std::uint16_t, Size> bits{};  // in the order they are sent
  std::array<std::uint8_t, Size> length{};
};

// RFC 1951, 3.2.2: codes of one length count upwards; they are sent from their most significant bit.
template <std::size_t Size>
void number_codes(Codes<Size>& codes) {
  std::uint32_t code = 0;
  for (std::uint32_t length = 1; length <= 15; ++length, code <<= 1) {
    for (std::size_t symbol = 0; symbol < Size; ++symbol) {
      if (codes.length[symbol] != length) continue;
      std::uint32_t reversed = 0;
      for (std::uint32_t bit = 0; bit < length; ++bit) reversed |= (code >> bit & 1u) << (length - 1 - bit);
      codes.bits[symbol] = static_cast<std::uint16_t>(reversed);
      ++code;
    }
  }
}

template <std::size_t Size>
Codes<Size> make_codes(const std::array<std::uint32_t, Size>& counts, int limit) {
  std::vector<std::uint16_t> used;  // rare first; equals by symbol, so that the result is the same everywhere
  for (std::uint16_t symbol = 0; symbol < Size; ++symbol) {
    if (counts[symbol] > 0) used.push_back(symbol);
  }
  std::ranges::stable_sort(used, {}, [&](std::uint16_t symbol) { return counts[symbol]; });
  std::vector<std::uint32_t> sorted;
  for (std::uint16_t symbol : used) sorted.push_back(counts[symbol]);

  Codes<Size> codes;
  if (used.size() < 2) {
    for (std::uint16_t symbol : used) codes.length[symbol] = 1;
  } else {
    std::array<int, 64> symbols_of_depth = depths_of(sorted);
    shorten(symbols_of_depth, limit);
    std::size_t next = 0;
    for (int depth = limit; depth > 0; --depth) {
      for (int i = symbols_of_depth[static_cast<std::size_t>(depth)]; i > 0; --i) {
        codes.length[used[next++]] = static_cast<std::uint8_t>(depth);
      }
    }
  }
  number_codes(codes);
  return codes;
}

// RFC 1951, 3.2.7: how the code lengths themselves are sent. 16 repeats the last one, 17 and 18 are runs of zero.
struct LengthToken {
  std::uint8_t symbol;
  std::uint8_t extra_bits;
  std::uint8_t extra;
};

std::vector<LengthToken> tokens_of(std::span<const std::uint8_t> lengths) {
  std::vector<LengthToken> tokens;
  for (std::size_t i = 0; i < lengths.size();) {
    const std::uint8_t length = lengths[i];
    std::size_t run = 1;
    while (i + run < lengths.size() && lengths[i + run] == length) ++run;
    i += run;
    if (length > 0) {
      tokens.push_back({length, 0, 0});
      --run;
    }
    for (const std::size_t shortest = 3; run >= shortest;) {
      const std::size_t taken = std::min<std::size_t>(run, length > 0 ? 6 : 138);
      if (length > 0) tokens.push_back({16, 2, static_cast<std::uint8_t>(taken - 3)});
      if (length == 0 && taken <= 10) tokens.push_back({17, 3, static_cast<std::uint8_t>(taken - 3)});
      if (length == 0 && taken > 10) tokens.push_back({18, 7, static_cast<std::uint8_t>(taken - 11)});
      run -= taken;
    }
    for (; run > 0; --run) tokens.push_back({length, 0, 0});
  }
  return tokens;
}

using LiteralCodes = Codes<kLiteralCodes>;

void put_block_head(BitWriter& writer, const LiteralCodes& literals, bool is_last) {
  static constexpr std::uint8_t kOrder[] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
  std::vector<std::uint8_t> lengths(literals.length.begin(), literals.length.end());
  lengths.push_back(1);  // the only distance code: 1
  const std::vector<LengthToken> tokens = tokens_of(lengths);
  std::array<std::uint32_t, 19> counts{};
  for (const LengthToken& token : tokens) ++counts[token.symbol];
  const Codes<19> codes = make_codes(counts, 7);
  std::size_t sent = std::size(kOrder);
  while (sent > 4 && codes.length[kOrder[sent - 1]] == 0) --sent;

  writer.put(is_last ? 1 : 0, 1);
  writer.put(2, 2);  // dynamic codes
  writer.put(kLiteralCodes - 257, 5);
  writer.put(0, 5);
  writer.put(sent - 4, 4);
  writer.flush();
  for (std::size_t i = 0; i < sent; ++i) {
    writer.put(codes.length[kOrder[i]], 3);
    writer.flush();
  }
  for (const LengthToken& token : tokens) {
    writer.put(codes.bits[token.symbol], codes.length[token.symbol]);
    writer.put(token.extra, token.extra_bits);
    writer.flush();
  }
}

// `length` bytes that equal the one before them.
struct Run {
  std::size_t begin;
  std::size_t length;
};

// Calls use(match length) until the run is used up; no rest is shorter than a match may be.
template <class Use>
void for_each_match(std::size_t length, Use&& use) {
  while (length > kLongestMatch) {
    const std::size_t taken = length - kLongestMatch < 3 ? kLongestMatch - 3 : kLongestMatch;
    use(taken);
    length -= taken;
  }
  use(length);
}

std::uint64_t load_64(const std::uint8_t* bytes) {
  std::uint64_t value;
  std::memcpy(&value, bytes, 8);
  return value;
}

// The runs of [begin, end) and how often each symbol is needed.
std::array<std::uint32_t, kLiteralCodes> find_runs(const std::uint8_t* bytes, std::size_t begin,
                                                   std::size_t end, std::vector<Run>& runs) {
  // Four tables, for equal neighbours must not wait for each other's count.
  std::array<std::array<std::uint32_t, 256>, 4> literals{};
  std::array<std::uint32_t, kLiteralCodes> counts{};
  runs.clear();
  std::size_t i = begin;
  if (i == 0 && i < end) ++literals[0][bytes[i++]];
  while (i + kShortestRun <= end) {
    if (load_64(bytes + i) != load_64(bytes + i - 1)) {
      ++literals[i & 3][bytes[i]];
      ++i;
      continue;
    }
    std::size_t length = kShortestRun;
    const auto repeats_8 = [&](std::size_t at) { return load_64(bytes + at) == load_64(bytes + at - 1); };
    while (i + length + 8 <= end && repeats_8(i + length)) length += 8;
    while (i + length < end && bytes[i + length] == bytes[i]) ++length;
    runs.push_back({i, length});
    for_each_match(length, [&](std::size_t match) { ++counts[kLengthCodes[match].symbol]; });
    i += length;
  }
  for (; i < end; ++i) ++literals[0][bytes[i]];
  for (const auto& table : literals) {
    for (std::size_t byte = 0; byte < 256; ++byte) counts[byte] += table[byte];
  }
  counts[kEndOfBlock] = 1;
  return counts;
}

// The writer is handed in and out by value, so that its state stays in registers.
BitWriter put_literals(BitWriter writer, const LiteralCodes& codes, std::span<const std::uint8_t> bytes) {
  std::size_t i = 0;
  for (; i + 4 <= bytes.size(); i += 4) {
    for (std::size_t k = 0; k < 4; ++k) writer.put(codes.bits[bytes[i + k]], codes.length[bytes[i + k]]);
    writer.flush();
  }
  for (; i < bytes.size(); ++i) writer.put(codes.bits[bytes[i]], codes.length[bytes[i]]);
  writer.flush();
  return writer;
}

BitWriter put_run(BitWriter writer, const LiteralCodes& codes, std::size_t length) {
  for_each_match(length, [&](std::size_t match) {
    const LengthCode& code = kLengthCodes[match];
    writer.put(codes.bits[code.symbol], codes.length[code.symbol]);
    writer.put(code.extra, code.extra_bits);
    writer.put(0, 1);  // distance 1
    writer.flush();
  });
  return writer;
}

}  // namespace

void append_run_deflated(std::span<const std::uint8_t> bytes, std::string& out) {
  out += "\x78\x01";  // deflate, window of 32 KiB, fastest
  std::vector<std::uint8_t> block(kBlockBytes * 2 + 1024);
  std::vector<Run> runs;
  BitWriter writer(block.data());
  std::size_t begin = 0;
  do {
    const std::size_t end = std::min(begin + kBlockBytes, bytes.size());
    const LiteralCodes codes = make_codes(find_runs(bytes.data(), begin, end, runs), kLongestCode);
    put_block_head(writer, codes, end == bytes.size());
    std::size_t at = begin;
    for (const Run& run : runs) {
      writer = put_literals(writer, codes, bytes.subspan(at, run.begin - at));
      writer = put_run(writer, codes, run.length);
      at = run.begin + run.length;
    }
    writer = put_literals(writer, codes, bytes.subspan(at, end - at));
    writer.put(codes.bits[kEndOfBlock], codes.length[kEndOfBlock]);
    writer.flush();
    if (end == bytes.size()) writer.align();
    out.append(reinterpret_cast<const char*>(block.data()),
               static_cast<std::size_t>(writer.at() - block.data()));
    writer.move_to(block.data());
    begin = end;
  } while (begin < bytes.size());

  const std::uint32_t sum = libdeflate_adler32(1, bytes.data(), bytes.size());
  for (int shift : {24, 16, 8, 0}) out.push_back(static_cast<char>(sum >> shift));
}

}  // namespace furnace
