// "UASTC LDR 4x4 Texture Specification"; ranges, weights and interpolation as ASTC's (Khronos Data Format 1.3,
// chapter 23).
#include "renderer/image/uastc_decode.hpp"

#include "renderer/image/basis_bits.hpp"

#include <algorithm>

namespace furnace {

namespace {

constexpr unsigned kModes = 19, kSolid = 8, kNoPlane = 4;

enum class Digits : std::uint8_t { kNone, kTrits, kQuints };

// Of an endpoint's number: plain bits under a digit of base 3 or 5.
struct Range {
  std::uint8_t bits;
  Digits digits;
};

constexpr Range k12{2, Digits::kTrits}, k16{4, Digits::kNone}, k32{5, Digits::kNone}, k40{3, Digits::kQuints},
    k48{4, Digits::kTrits}, k160{5, Digits::kQuints}, k192{6, Digits::kTrits}, k256{8, Digits::kNone};

struct Mode {
  std::uint8_t code_bits;  // of the mode itself
  std::uint8_t hint_bits;  // for other transcoders
  std::uint8_t subsets, planes, components, weight_bits;
  Range range;
};

constexpr std::array<Mode, kModes> kMode{{
    {4, 15, 1, 1, 3, 4, k192}, {6, 15, 1, 1, 3, 2, k256}, {5, 15, 2, 1, 3, 3, k16},
    {5, 15, 3, 1, 3, 2, k12},  {5, 15, 2, 1, 3, 2, k40},  {5, 15, 1, 1, 3, 3, k256},
    {5, 15, 1, 2, 3, 2, k160}, {5, 15, 2, 1, 3, 2, k40},  {5, 0, 1, 1, 4, 0, k256},
    {5, 23, 2, 1, 4, 2, k16},  {3, 17, 1, 1, 4, 4, k48},  {2, 17, 1, 2, 4, 2, k48},
    {3, 17, 1, 1, 4, 3, k192}, {5, 23, 1, 2, 4, 1, k256}, {5, 23, 1, 1, 4, 2, k256},
    {7, 23, 1, 1, 2, 4, k256}, {6, 23, 2, 1, 2, 2, k256}, {6, 23, 1, 2, 2, 2, k256},
    {4, 15, 1, 1, 3, 5, k32},
}};

// The codes of the modes, the first bit lowest, in the order of their lengths.
struct ModeCode {
  std::uint8_t code, bits, mode;
};
constexpr std::array<ModeCode, kModes> kModeCodes{{{0x00, 2, 11},
                                                   {0x02, 3, 10},
                                                   {0x06, 3, 12},
                                                   {0x01, 4, 0},
                                                   {0x09, 4, 18},
                                                   {0x03, 5, 3},
                                                   {0x13, 5, 4},
                                                   {0x07, 5, 7},
                                                   {0x17, 5, 8},
                                                   {0x0b, 5, 5},
                                                   {0x1b, 5, 6},
                                                   {0x0d, 5, 14},
                                                   {0x1d, 5, 2},
                                                   {0x0f, 5, 9},
                                                   {0x1f, 5, 13},
                                                   {0x15, 6, 16},
                                                   {0x35, 6, 1},
                                                   {0x25, 6, 17},
                                                   {0x05, 7, 15}}};

// A bit a texel, the first lowest: those of subset 1.
constexpr std::array<std::uint16_t, 30> kTwoSubsets{
    0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f, 0xc800, 0x0013,
    0xfe80, 0x17ff, 0x0017, 0x00ff, 0xfff0, 0x0fff, 0xff71, 0x8eff, 0x08ce, 0x008c,
    0x7310, 0xceff, 0x7331, 0x088c, 0xceef, 0x6666, 0xf00f, 0x5555, 0x0f0f, 0x36c9};
constexpr std::array<std::uint16_t, 19> kTwoSubsetsOfMode7{
    0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8, 0xccce, 0x3c03, 0x00ee,
    0x7700, 0x3003, 0x00ce, 0xff80, 0x6fff, 0x1333, 0x11ff, 0x136c, 0x00ef};
// Subset 1 in the lower half, subset 2 in the upper one.
constexpr std::array<std::uint32_t, 11> kThreeSubsets{0xcc003300, 0xf00000ff, 0xf000000f, 0x00f0000f,
                                                      0x44443333, 0x88886666, 0x2222cccc, 0x1111ee00,
                                                      0x99994444, 0x0f00f00f, 0xc00c0cc0};

constexpr unsigned mode_of(unsigned low_bits) {
  for (const ModeCode& entry : kModeCodes) {
    if ((low_bits & ((1u << entry.bits) - 1)) == entry.code) return entry.mode;
  }
  return kModes;
}

std::uint32_t spread(std::uint32_t bits) {
  std::uint32_t result = 0;
  for (unsigned i = 0; i < 16; ++i) result |= (bits >> i & 1) << (2 * i);
  return result;
}

// ASTC's A, B, C and D: a number of a range brought to 8 bits.
std::uint8_t widened(std::uint32_t number, Range range) {
  const unsigned bits = range.bits;
  if (range.digits == Digits::kNone) {
    std::uint32_t result = 0;
    for (int shift = 8 - int(bits); shift > -int(bits); shift -= int(bits))
      result |= shift >= 0 ? number << shift : number >> -shift;
    return std::uint8_t(result);
  }
  const std::uint32_t digit = number >> bits, a = (number & 1) != 0 ? 0x1ff : 0;
  const std::uint32_t x = (number & ((1u << bits) - 1)) >> 1;  // the bits above the lowest
  std::uint32_t b = 0, c = 0;
  if (range.digits == Digits::kTrits) {
    switch (bits) {
      case 2:  // b000b0bb0
        b = x << 8 | x << 4 | x << 2 | x << 1, c = 93;
        break;
      case 4:  // dcb000dcb
        b = x << 6 | x, c = 22;
        break;
      default:  // fedcb000f
        b = x << 4 | x >> 4, c = 5;
        break;
    }
  } else if (bits == 3) {  // cb0000cbc
    b = x << 7 | x << 1 | x >> 1, c = 26;
  } else {  // edcb0000e
    b = x << 5 | x >> 3, c = 6;
  }
  const std::uint32_t t = (digit * c + b) ^ a;
  return std::uint8_t((a & 0x80) | t >> 2);
}

using Endpoints = std::array<std::uint8_t, 18>;

// All digits come first, packed as numbers of base 3 or 5, then each number's bits.
void read_endpoints(LsbBits& bits, const Mode& mode, Endpoints& out) {
  const std::size_t count = std::size_t(mode.components) * 2 * mode.subsets;
  const Range range = mode.range;
  const bool trits = range.digits == Digits::kTrits;
  const std::uint32_t base = trits ? 3 : 5;
  const std::size_t bundle = trits ? 5 : 3;
  constexpr std::array<std::uint8_t, 6> kTritBits{0, 2, 4, 5, 7, 8}, kQuintBits{0, 3, 5, 7, 7, 7};
  std::array<std::uint8_t, 20> digits{};
  for (std::size_t first = 0; range.digits != Digits::kNone && first < count; first += bundle) {
    const std::size_t left = std::min(bundle, count - first);
    std::uint32_t packed = bits.take((trits ? kTritBits : kQuintBits)[left]);
    for (std::size_t i = 0; i < left; ++i, packed /= base) digits[first + i] = std::uint8_t(packed % base);
  }
  for (std::size_t i = 0; i < count; ++i)
    out[i] = widened(std::uint32_t(digits[i]) << range.bits | bits.take(range.bits), range);
}

// In 64ths.
unsigned widened_weight(unsigned weight, unsigned bits) {
  unsigned wide = 0;
  for (int shift = 6 - int(bits); shift > -int(bits); shift -= int(bits))
    wide |= shift >= 0 ? weight << shift : weight >> -shift;
  return wide + (wide > 32 ? 1 : 0);
}

std::uint8_t mixed(unsigned low, unsigned high, unsigned weight) {
  return std::uint8_t((low * 257 * (64 - weight) + high * 257 * weight + 32) >> 14);
}

void read_solid(LsbBits& bits, UastcTexels& out) {
  for (std::size_t c = 0; c < 4; ++c) out[0][c] = std::uint8_t(bits.take(8));
  out.fill(std::array(out[0]));
}

// Of luminance and alpha: the first pair is all three colours.
std::array<std::uint8_t, 4> color_of(const Mode& mode, const Endpoints& endpoints, unsigned subset,
                                     const std::array<unsigned, 4>& weights) {
  std::array<std::uint8_t, 4> color{0, 0, 0, 255};
  for (unsigned c = 0; c < 4; ++c) {
    const unsigned component = mode.components == 2 ? c / 3 : c;
    if (component >= mode.components) continue;
    const std::size_t at = (std::size_t(subset) * mode.components + component) * 2;
    color[c] = mixed(endpoints[at], endpoints[at + 1], weights[c]);
  }
  return color;
}

}  // namespace

std::size_t uastc_pattern_count(unsigned mode) {
  if (kMode[mode].subsets == 3) return kThreeSubsets.size();
  return mode == 7 ? kTwoSubsetsOfMode7.size() : kTwoSubsets.size();
}

std::uint32_t uastc_pattern(unsigned mode, std::size_t index) {
  if (kMode[mode].subsets == 3)
    return spread(kThreeSubsets[index] & 0xffff) | spread(kThreeSubsets[index] >> 16) << 1;
  return spread(mode == 7 ? kTwoSubsetsOfMode7[index] : kTwoSubsets[index]);
}

bool decode_uastc_block(std::span<const std::byte> block, UastcTexels& out) {
  LsbBits bits(block);
  const unsigned number = mode_of(bits.peek(7));
  if (number == kModes) return false;
  const Mode& mode = kMode[number];
  bits.skip(mode.code_bits);
  if (number == kSolid) {
    read_solid(bits, out);
    return true;
  }
  bits.skip(mode.hint_bits);
  std::uint32_t pattern = 0;
  if (mode.subsets > 1) {
    const std::size_t index = bits.take(mode.subsets == 2 ? 5 : 4);
    if (index >= uastc_pattern_count(number)) return false;
    pattern = uastc_pattern(number, index);
  }
  constexpr unsigned kAlpha = 3;
  unsigned second_plane = kNoPlane;
  if (mode.planes == 2) second_plane = mode.components == 2 ? kAlpha : bits.take(2);
  Endpoints endpoints{};
  read_endpoints(bits, mode, endpoints);

  unsigned seen = 0;  // subsets whose first texel was met: its weight lacks the highest bit, which is 0
  for (unsigned i = 0; i < 16; ++i) {
    const unsigned subset = pattern >> (2 * i) & 3;
    const bool anchor = (seen >> subset & 1) == 0;
    seen |= 1u << subset;
    std::array<unsigned, 4> weights{};
    for (unsigned plane = 0; plane < mode.planes; ++plane) {
      const unsigned weight =
          widened_weight(bits.take(mode.weight_bits - (anchor ? 1 : 0)), mode.weight_bits);
      for (unsigned c = 0; c < 4; ++c) {
        if (plane == 0 || c == second_plane) weights[c] = weight;
      }
    }
    out[i] = color_of(mode, endpoints, subset, weights);
  }
  return true;
}

}  // namespace furnace
