// KTX 2.0, "BasisLZ/ETC1S Bitstream Specification".
#include "renderer/image/etc1s_decode.hpp"

#include "renderer/image/codecs.hpp"
#include "renderer/image/ktx2_container.hpp"
#include "renderer/base/error.hpp"

#include <algorithm>
#include <utility>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "KTX2";

// Of ETC1 (Khronos Data Format 1.3, table 92): smaller and larger.
constexpr std::array<std::array<int, 2>, 8> kIntensities{
    {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};

// Values sent in pieces, the highest bit of each telling whether another follows.
std::uint32_t read_pieces(LsbBits& bits, unsigned size) {
  std::uint32_t value = 0;
  for (unsigned shift = 0; shift < 32; shift += size) {
    const std::uint32_t piece = bits.take(size + 1);
    value |= (piece & ((1u << size) - 1)) << shift;
    if (piece >> size == 0) return value;
  }
  fail_damaged(kFormat, "a number in it");
}

// Approximately moves to the front what is used: selectors that were seen lately.
class History {
 public:
  explicit History(std::size_t size) : values_(size), next_(size / 2) {}

  void add(std::uint32_t value) {
    if (values_.empty()) return;
    values_[next_++] = value;
    if (next_ == values_.size()) next_ = values_.size() / 2;
  }
  std::uint32_t use(std::size_t index) {
    if (index >= values_.size()) fail_damaged(kFormat, "a selector in it");
    const std::uint32_t value = values_[index];
    std::swap(values_[index / 2], values_[index]);
    return value;
  }

 private:
  std::vector<std::uint32_t> values_;
  std::size_t next_;
};

// How endpoints are found: two bits a block, sent for 2 x 2 blocks at once.
class Predictions {
 public:
  Predictions(LsbBits& bits, const HuffmanTable& code, int blocks_x)
      : bits_(bits), code_(code), below_(std::size_t(blocks_x + 1) / 2) {}

  std::uint32_t next(int x, int y) {
    if (x % 2 == 0) {
      auto& below = below_[std::size_t(x) / 2];
      if (y % 2 == 0) {
        current_ = read();
        below = std::uint8_t(current_ >> 4);
      } else {
        current_ = below;
      }
    }
    const std::uint32_t prediction = current_ & 3;
    current_ >>= 2;
    return prediction;
  }

 private:
  std::uint32_t read() {
    constexpr std::uint32_t kRepeat = 256, kLeastRepeats = 3;
    if (repeats_ > 0) {
      --repeats_;
      return last_;
    }
    const std::uint32_t symbol = code_.read(bits_);
    if (symbol > kRepeat) fail_damaged(kFormat, "a prediction in it");
    if (symbol == kRepeat) {
      repeats_ = std::uint64_t(read_pieces(bits_, 4)) + kLeastRepeats - 1;
    } else {
      last_ = symbol;
    }
    return last_;
  }

  LsbBits& bits_;
  const HuffmanTable& code_;
  std::vector<std::uint8_t> below_;
  std::uint32_t current_ = 0, last_ = 0;
  std::uint64_t repeats_ = 0;
};

// Threads: one. Owns: what one block needs to know of those before it.
class SelectorReader {
 public:
  SelectorReader(LsbBits& bits, const HuffmanTable& code, const HuffmanTable& run_code, std::uint32_t count,
                 std::uint32_t history_size)
      : bits_(bits),
        code_(code),
        run_code_(run_code),
        count_(count),
        run_symbol_(count + history_size),
        history_(history_size) {}

  std::uint32_t next() {
    if (run_ == 0) {
      const std::uint32_t symbol = code_.read(bits_);
      if (symbol < count_) {
        history_.add(symbol);
        return symbol;
      }
      if (symbol != run_symbol_) return history_.use(symbol - count_);
      run_ = read_run();
    }
    --run_;
    return history_.use(0);
  }

 private:
  std::uint64_t read_run() {
    constexpr std::uint32_t kLeast = 3, kLong = 63;
    const std::uint32_t symbol = run_code_.read(bits_);
    return kLeast + std::uint64_t(symbol == kLong ? read_pieces(bits_, 7) : symbol);
  }

  LsbBits& bits_;
  const HuffmanTable& code_;
  const HuffmanTable& run_code_;
  const std::uint32_t count_, run_symbol_;
  History history_;
  std::uint64_t run_ = 0;
};

}  // namespace

Etc1sCodebooks::Etc1sCodebooks(std::span<const std::byte> data, std::size_t levels) {
  constexpr std::size_t kHeader = 20, kPicture = 20;
  constexpr std::uint32_t kPFrame = 2;
  if (data.size() < kHeader + kPicture * levels) fail_damaged(kFormat, "its global data");
  endpoints_.resize(read_u16(data, 0));
  selectors_.resize(read_u16(data, 2));
  const std::array<std::uint64_t, 3> sizes{read_u32(data, 4), read_u32(data, 8), read_u32(data, 12)};
  for (std::size_t i = 0; i < levels; ++i) {
    const std::size_t at = kHeader + i * kPicture;
    if ((read_u32(data, at) & kPFrame) != 0)
      fail(ErrorCode::kUnsupportedMedia, "a KTX2 video is not a texture");
    pictures_.push_back({{read_u32(data, at + 4), read_u32(data, at + 8)},
                         {read_u32(data, at + 12), read_u32(data, at + 16)}});
  }
  std::span<const std::byte> rest = data.subspan(kHeader + kPicture * levels);
  std::array<std::span<const std::byte>, 3> parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (sizes[i] > rest.size()) fail_damaged(kFormat, "its global data");
    parts[i] = rest.first(sizes[i]);
    rest = rest.subspan(sizes[i]);
  }
  if (endpoints_.empty() || selectors_.empty()) fail_damaged(kFormat, "its codebooks are empty");
  read_endpoints(parts[0]);
  read_selectors(parts[1]);
  read_tables(parts[2]);
}

void Etc1sCodebooks::read_endpoints(std::span<const std::byte> bytes) {
  LsbBits bits(bytes);
  std::array<HuffmanTable, 3> color_codes;  // by the value before: low, middle, high
  for (HuffmanTable& code : color_codes) code = read_huffman_table(bits);
  const HuffmanTable table_code = read_huffman_table(bits);
  const bool grey = bits.take(1) != 0;
  Endpoint last{{16, 16, 16}, 0};
  for (Endpoint& endpoint : endpoints_) {
    last.table = std::uint8_t((last.table + table_code.read(bits)) & 7);
    for (std::size_t c = 0; c < (grey ? 1 : 3); ++c) {
      const std::uint8_t before = last.color[c];
      const HuffmanTable& code = color_codes[before <= 9 ? 0 : before <= 21 ? 1 : 2];
      last.color[c] = std::uint8_t((before + code.read(bits)) & 31);
    }
    if (grey) last.color[1] = last.color[2] = last.color[0];
    endpoint = last;
  }
}

void Etc1sCodebooks::read_selectors(std::span<const std::byte> bytes) {
  LsbBits bits(bytes);
  if (bits.take(2) != 0) fail_damaged(kFormat, "its selectors");
  const bool plain = bits.take(1) != 0;
  const HuffmanTable code = plain ? HuffmanTable() : read_huffman_table(bits);
  Selector last{};
  for (std::size_t i = 0; i < selectors_.size(); ++i) {
    for (std::uint8_t& row : last) row = std::uint8_t(plain || i == 0 ? bits.take(8) : row ^ code.read(bits));
    selectors_[i] = last;
  }
  if (bits.overrun()) fail_damaged(kFormat, "its selectors end early");
}

void Etc1sCodebooks::read_tables(std::span<const std::byte> bytes) {
  LsbBits bits(bytes);
  prediction_code_ = read_huffman_table(bits);
  endpoint_code_ = read_huffman_table(bits);
  selector_code_ = read_huffman_table(bits);
  run_code_ = read_huffman_table(bits);
  history_size_ = bits.take(13);
  if (bits.overrun()) fail_damaged(kFormat, "its tables end early");
}

std::vector<std::uint8_t> Etc1sCodebooks::decode(std::span<const std::byte> slice, Extent extent) const {
  enum Prediction : std::uint32_t { kLeft, kAbove, kAboveLeft, kSent };
  const int blocks_x = (extent.width + 3) / 4, blocks_y = (extent.height + 3) / 4;
  LsbBits bits(slice);
  Predictions predictions(bits, prediction_code_, blocks_x);
  SelectorReader selectors(bits, selector_code_, run_code_, std::uint32_t(selectors_.size()), history_size_);
  std::vector<std::uint32_t> above(std::size_t(blocks_x), 0), here(std::size_t(blocks_x), 0);
  std::vector<std::uint8_t> rgb(std::size_t(extent.area()) * 3);
  std::uint32_t last = 0;
  for (int y = 0; y < blocks_y; ++y) {
    for (int x = 0; x < blocks_x; ++x) {
      const std::uint32_t prediction = predictions.next(x, y);
      const bool has_left = x > 0, has_above = y > 0;
      std::uint32_t endpoint = last;
      if (prediction == kSent) {
        endpoint += endpoint_code_.read(bits);
        if (endpoint >= endpoints_.size()) endpoint -= std::uint32_t(endpoints_.size());
      } else if ((prediction != kAbove && !has_left) || (prediction != kLeft && !has_above)) {
        fail_damaged(kFormat, "a prediction in it");
      } else if (prediction != kLeft) {
        endpoint = above[std::size_t(prediction == kAbove ? x : x - 1)];
      }
      const std::uint32_t selector = selectors.next();
      if (endpoint >= endpoints_.size() || selector >= selectors_.size())
        fail_damaged(kFormat, "an index into its codebooks");
      here[std::size_t(x)] = last = endpoint;
      paint(endpoints_[endpoint], selectors_[selector], extent, x, y, rgb);
    }
    std::swap(above, here);
  }
  return rgb;
}

void Etc1sCodebooks::paint(const Endpoint& endpoint, const Selector& selector, Extent extent, int block_x,
                           int block_y, std::vector<std::uint8_t>& rgb) const {
  const auto [small, large] = kIntensities[endpoint.table];
  const std::array<int, 4> steps{-large, -small, small, large};
  std::array<std::array<std::uint8_t, 3>, 4> colors;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int base = endpoint.color[c] << 3 | endpoint.color[c] >> 2;
      colors[i][c] = std::uint8_t(std::clamp(base + steps[i], 0, 255));
    }
  }
  const int rows = std::min(4, extent.height - 4 * block_y),
            columns = std::min(4, extent.width - 4 * block_x);
  for (int y = 0; y < rows; ++y) {
    auto out = rgb.begin() + ((std::ptrdiff_t(block_y) * 4 + y) * extent.width + block_x * 4) * 3;
    for (int x = 0; x < columns; ++x)
      out = std::ranges::copy(colors[selector[std::size_t(y)] >> (2 * x) & 3], out).out;
  }
}

}  // namespace furnace
