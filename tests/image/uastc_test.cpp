// UASTC blocks written here by the specification's tables, patterns against ASTC's own generator of them.
#include "tests/image/ktx2_files.hpp"
#include "tests/image/sample_files.hpp"
#include "tests/support/hex.hpp"
#include "renderer/image/uastc_decode.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>
#include <string_view>
#include <vector>

namespace furnace {
namespace {

// The mode by the lowest seven bits of a block; 19 is reserved.
constexpr std::uint8_t kModeOfBits[128] = {
    11, 0,  10, 3, 11, 15, 12, 7,  11, 18, 10, 5,  11, 14, 12, 9,  11, 0,  10, 4,  11, 16, 12, 8,  11, 18,
    10, 6,  11, 2, 12, 13, 11, 0,  10, 3,  11, 17, 12, 7,  11, 18, 10, 5,  11, 14, 12, 9,  11, 0,  10, 4,
    11, 1,  12, 8, 11, 18, 10, 6,  11, 2,  12, 13, 11, 0,  10, 3,  11, 19, 12, 7,  11, 18, 10, 5,  11, 14,
    12, 9,  11, 0, 10, 4,  11, 16, 12, 8,  11, 18, 10, 6,  11, 2,  12, 13, 11, 0,  10, 3,  11, 17, 12, 7,
    11, 18, 10, 5, 11, 14, 12, 9,  11, 0,  10, 4,  11, 1,  12, 8,  11, 18, 10, 6,  11, 2,  12, 13};

struct Mode {
  unsigned code_bits, hints, subsets, planes, components, weight_bits, bits, base;  // base 1: plain numbers
};
constexpr Mode kModes[19] = {{4, 15, 1, 1, 3, 4, 6, 3}, {6, 15, 1, 1, 3, 2, 8, 1}, {5, 15, 2, 1, 3, 3, 4, 1},
                             {5, 15, 3, 1, 3, 2, 2, 3}, {5, 15, 2, 1, 3, 2, 3, 5}, {5, 15, 1, 1, 3, 3, 8, 1},
                             {5, 15, 1, 2, 3, 2, 5, 5}, {5, 15, 2, 1, 3, 2, 3, 5}, {5, 0, 1, 1, 4, 0, 8, 1},
                             {5, 23, 2, 1, 4, 2, 4, 1}, {3, 17, 1, 1, 4, 4, 4, 3}, {2, 17, 1, 2, 4, 2, 4, 3},
                             {3, 17, 1, 1, 4, 3, 6, 3}, {5, 23, 1, 2, 4, 1, 8, 1}, {5, 23, 1, 1, 4, 2, 8, 1},
                             {7, 23, 1, 1, 2, 4, 8, 1}, {6, 23, 2, 1, 2, 2, 8, 1}, {6, 23, 1, 2, 2, 2, 8, 1},
                             {4, 15, 1, 1, 3, 5, 5, 1}};

const std::vector<std::vector<int>> kWeights = {
    {},
    {0, 64},
    {0, 21, 43, 64},
    {0, 9, 18, 27, 37, 46, 55, 64},
    {0, 4, 8, 12, 17, 21, 25, 29, 35, 39, 43, 47, 52, 56, 60, 64},
    {0,  2,  4,  6,  8,  10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30,
     34, 36, 38, 40, 42, 44, 46, 48, 50, 52, 54, 56, 58, 60, 62, 64}};

unsigned code_of(unsigned mode) {
  for (unsigned i = 0; i < 128; ++i) {
    if (kModeOfBits[i] == mode) return i & ((1u << kModes[mode].code_bits) - 1);
  }
  return 0;
}

void put_endpoints(const Mode& mode, const std::vector<unsigned>& numbers, sample::BitWriter& out) {
  const std::size_t bundle = mode.base == 3 ? 5 : 3;
  for (std::size_t first = 0; mode.base > 1 && first < numbers.size(); first += bundle) {
    const std::size_t count = std::min(bundle, numbers.size() - first);
    unsigned packed = 0;
    for (std::size_t i = count; i-- > 0;) packed = packed * mode.base + (numbers[first + i] >> mode.bits);
    // As many bits as the largest such number needs.
    unsigned width = 0;
    while ((1u << width) < std::pow(mode.base, count)) ++width;
    out.put(packed, width);
  }
  for (const unsigned number : numbers) out.put(number & ((1u << mode.bits) - 1), mode.bits);
}

struct Block {
  std::vector<unsigned> endpoints, weights;  // numbers as stored
  std::size_t pattern = 0;
  unsigned second_plane = 0;
};

std::string encoded(unsigned number, const Block& block) {
  const Mode& mode = kModes[number];
  sample::BitWriter out;
  out.put(code_of(number), mode.code_bits);
  out.put(0x155555, mode.hints);
  if (mode.subsets > 1) out.put(unsigned(block.pattern), mode.subsets == 2 ? 5 : 4);
  if (mode.planes == 2 && mode.components > 2) out.put(block.second_plane, 2);
  put_endpoints(mode, block.endpoints, out);
  const std::uint32_t pattern = mode.subsets > 1 ? uastc_pattern(number, block.pattern) : 0;
  std::set<unsigned> seen;
  for (unsigned i = 0; i < 16; ++i) {
    const bool anchor = seen.insert(pattern >> (2 * i) & 3).second;
    for (unsigned plane = 0; plane < mode.planes; ++plane)
      out.put(block.weights[i * mode.planes + plane], mode.weight_bits - (anchor ? 1 : 0));
  }
  return out.take(16);
}

UastcTexels decoded(const std::string& block) {
  UastcTexels texels{};
  EXPECT_TRUE(decode_uastc_block(std::as_bytes(std::span(block)), texels));
  return texels;
}

// A random block whose endpoints are 0 or 255: codes 0 and 1 of a range with digits, 0 and the last of a plain one.
Block random_block(unsigned number, std::mt19937& random) {
  const Mode& mode = kModes[number];
  Block block;
  if (mode.subsets > 1) block.pattern = random() % uastc_pattern_count(number);
  block.second_plane = mode.components == 2 ? 3 : unsigned(random() % 4);
  const unsigned full = mode.base > 1 ? 1 : (1u << mode.bits) - 1;
  for (unsigned i = 0; i < mode.components * 2 * mode.subsets; ++i)
    block.endpoints.push_back(random() % 2 ? full : 0);
  const std::uint32_t pattern = mode.subsets > 1 ? uastc_pattern(number, block.pattern) : 0;
  std::set<unsigned> seen;
  for (unsigned i = 0; i < 16; ++i) {
    const bool anchor = seen.insert(pattern >> (2 * i) & 3).second;
    for (unsigned plane = 0; plane < mode.planes; ++plane)
      block.weights.push_back(unsigned(random()) % (1u << (mode.weight_bits - (anchor ? 1 : 0))));
  }
  return block;
}

TEST(Uastc, EveryModeMixesItsEndpoints) {
  std::mt19937 random(1);
  for (unsigned number = 0; number < 19; ++number) {
    if (number == 8) continue;
    const Mode& mode = kModes[number];
    for (int round = 0; round < 50; ++round) {
      const Block block = random_block(number, random);
      const UastcTexels texels = decoded(encoded(number, block));
      const std::uint32_t pattern = mode.subsets > 1 ? uastc_pattern(number, block.pattern) : 0;
      for (unsigned i = 0; i < 16; ++i) {
        for (unsigned c = 0; c < 4; ++c) {
          const unsigned component = mode.components == 2 ? (c == 3 ? 1 : 0) : c;
          double expected = 255;
          if (component < mode.components) {
            const bool second = mode.planes == 2 && c == block.second_plane;
            const unsigned weight = block.weights[i * mode.planes + (second ? 1 : 0)];
            const std::size_t at = ((pattern >> (2 * i) & 3) * mode.components + component) * 2;
            const double share = kWeights[mode.weight_bits][weight] / 64.0;
            const double low = block.endpoints[at] ? 255 : 0, high = block.endpoints[at + 1] ? 255 : 0;
            expected = low + (high - low) * share;
          }
          ASSERT_NEAR(texels[i][c], expected, 1) << "mode " << number << " texel " << i << " channel " << c;
        }
      }
    }
  }
}

// A block of each mode as Basis Universal 1.16 wrote it, with the texels of its own transcoder.
TEST(Uastc, ReadsTheReferenceEncodersBlocks) {
  struct Row {
    std::string_view block, texels;
  };
  constexpr std::array<Row, 19> kByMode{{
      {"81401ba0bcfa1e0078fb62da51c83096",
       "be8700ffc38700ffcb8700ffd28700ffbb8700ffc28700ffc98700ffcf8700ffb98700ffc08700ffc68700ffcd8700ff"
       "b78700ffbc8700ffc28700ffc88700ff"},
      {"f500ec8929c322c3c281512101000000",
       "4f1919ff4c1616ff4e1818ff4f1919ff4f1919ff4d1717ff4e1818ff4f1919ff4e1818ff4e1818ff4e1818ff4f1919ff"
       "4d1717ff4f1919ff4e1818ff4f1919ff"},
      {"1d3592392c013a0301ea57ec69640100",
       "b26d00ffd42100ff998800ff119900ff977400ffd42100ffa37700ff2b9200ff7d7c00ffca3200ffc14300ff608300ff"
       "608300ffac6600ffdd1100ffcc6600ff"},
      {"03a559de7a9ae4bcd44bbdc2bf6a1500",
       "c25cd1ff5c5ce8ff5c5ce8ff745ce8ffd18bd1ff5ca3ffff5ca3ffff74a3ffffca74d1ff5c8cf8ff5c8cf8ff748cf8ff"
       "c25cd1ff5c73f0ff5c73f0ff7473f0ff"},
      {"9320fb60323bedef97ff4f0041f67200",
       "8a84ffff8a84ffff8a84ffff8a84ffff8a88fbff8a84ffff8a84ffff8a88fbff8a8df7ff8a88fbff8a91f2ff8a91f2ff"
       "8ab8dfff88b0e6ff86a7ecff849ef2ff"},
      {"cb81dd24946191614112adaacbf60600",
       "4d1919ff4b1818ff4b1818ff4b1818ff4a1818ff481717ff451616ff4a1818ff451616ff431616ff451616ff461717ff"
       "451616ff451616ff421616ff431616ff"},
      {"fb03cbe4ca1c108440c851d962ea73fb",
       "360013ff380013ff3a0013ff3c0013ff360313ff380313ff3a0313ff3c0313ff360713ff380713ff3a0713ff3c0713ff"
       "360b14ff380b14ff3a0b14ff3c0b14ff"},
      {"07101be41d79daff93d64f4e4ed45a00",
       "8284feff9184f9ffa47bf9ff8a84fbff7b84ffff9184f9ffa887f3ff8a84fbff7b84ffff8a84fbffad93ecff8a84fbff"
       "8284feff8284feffb19ee5ff8a84fbff"},
      {"1710f0ff9f3ce7010000000000000000",
       "8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff8080ffff"
       "8080ffff8080ffff8080ffff8080ffff"},
      {"cf2620e7e017d8bfe0dd00f4b538b405",
       "00bbccff547ed7c7ff00ee55ab3de38d00ee00aa00ee00aaff6600ff54c200c600ee00aaab9300e3ab9300e354c200c6"
       "ff6600ffab9300e300ee00aa00ee00aa"},
      {"92dde1112424248876fbea6251d9c840",
       "3c3c3c207a7a7a20bcbcbc20fafafa20adadad20ececec202d2d2d206b6b6b201e1e1e205d5d5d209f9f9f20dddddd20"
       "90909020cecece20101010204e4e4e20"},
      {"00e88031fc45100140c851d962ea73fb",
       "83ff26009aff2600b2ff2600c9ff260083fc26009afc2600b2fc2600c9fc260083f826009af82600b2f82600c9f82600"
       "83f426009af42600b2f42600c9f42600"},
      {"06d921af1ba1111a4120567097537097",
       "87878707a6a6a607c6c6c606e5e5e5060606060a25252509444444086464640887878707a6a6a607c6c6c606e5e5e506"
       "0606060a252525094444440864646408"},
      {"1f9302c1834081000aca0c8ecadfdf0f",
       "0f0528330205283302052833020528330f0528330202283802022838020228380f022838020228380202283802022838"
       "0f022838020228380202283802022838"},
      {"ed932c4140400b8882c26102a852fd07",
       "04b4281c04b4281c04b4281c04b4281c04a3281f04a3281f04a3281f04a3281f04912822049128220491282204912822"
       "04802826048028260480282604802826"},
      {"05245bc7c7aa2d2d4286ca0e5397db1f",
       "1f1f1fb6272727b6303030b6393939b6444444b64d4d4db6565656b55e5e5eb56b6b6bb5747474b57d7d7db5868686b5"
       "919191b59a9a9ab4a2a2a2b4abababb4"},
      {"150bbb030068b8bb0380a8ab0355aaff",
       "000000ee000000ee000000ea000000ea080808ee080808ee0a0a0aea0a0a0aea111111ee111111ee151515ea151515ea"
       "1a1a1aee1a1a1aee202020ea202020ea"},
      {"e548ad0340e53c1c428eca16539fdb07",
       "000000e7000000e5000000e3000000e10d0d0de70d0d0de50d0d0de30d0d0de11c1c1ce71c1c1ce51c1c1ce31c1c1ce1"
       "2a2a2ae72a2a2ae52a2a2ae32a2a2ae1"},
      {"295b1359649121451d16e5a2594f1efe",
       "101010ff454545ff7b7b7bffb1b1b1ff161616ff515151ff8d8d8dffbcbcbcff1b1b1bff5d5d5dff999999ffc8c8c8ff"
       "272727ff696969ffa5a5a5ffcececeff"},
  }};
  for (const Row& row : kByMode) {
    UastcTexels texels;
    const std::vector<std::uint8_t> block = test::bytes_of_hex(row.block);
    ASSERT_TRUE(decode_uastc_block(std::as_bytes(std::span(block)), texels)) << row.block;
    const std::vector<std::uint8_t> expected = test::bytes_of_hex(row.texels);
    for (std::size_t i = 0; i < 64; ++i)
      EXPECT_EQ(texels[i / 4][i % 4], expected[i]) << row.block << " " << i;
  }
}

// The numbers of a range stand for evenly spaced values from 0 to 255, in an order of their own.
TEST(Uastc, RangesAreEven) {
  for (unsigned number = 0; number < 19; ++number) {
    if (number == 8) continue;
    const Mode& mode = kModes[number];
    const unsigned count = mode.base << mode.bits;
    std::set<int> values;
    for (unsigned code = 0; code < count; ++code) {
      Block block;
      block.endpoints.assign(mode.components * 2 * mode.subsets, code);
      block.weights.assign(16 * mode.planes, 0);
      values.insert(decoded(encoded(number, block))[0][0]);
    }
    ASSERT_EQ(values.size(), count) << number;
    double place = 0;
    for (const int value : values) EXPECT_NEAR(value, place++ * 255 / (count - 1), 1.5) << number;
  }
}

TEST(Uastc, SolidBlocks) {
  sample::BitWriter out;
  out.put(code_of(8), 5);
  for (const unsigned value : {12, 200, 3, 77}) out.put(value, 8);
  for (const auto& texel : decoded(out.take(16)))
    EXPECT_EQ(texel, (std::array<std::uint8_t, 4>{12, 200, 3, 77}));
}

TEST(Uastc, RefusesWhatIsReserved) {
  UastcTexels texels;
  for (unsigned bits = 0; bits < 128; ++bits) {
    std::string block(16, '\0');
    block[0] = char(bits);
    EXPECT_EQ(decode_uastc_block(std::as_bytes(std::span(block)), texels), kModeOfBits[bits] != 19) << bits;
  }
  for (const unsigned mode : {2u, 3u, 4u, 7u, 9u, 16u}) {
    std::mt19937 random(2);
    Block block = random_block(mode, random);
    std::string file = encoded(mode, block);
    // All ones in the bits of the pattern, which follow the hints.
    const unsigned at = kModes[mode].code_bits + kModes[mode].hints;
    for (unsigned i = at; i < at + (mode == 3 ? 4 : 5); ++i)
      file[i / 8] = char(std::uint8_t(file[i / 8]) | 1 << i % 8);
    EXPECT_FALSE(decode_uastc_block(std::as_bytes(std::span(file)), texels)) << mode;
  }
}

// ASTC's partition function (Khronos Data Format 1.3, 23.21) for 4 x 4 blocks.
unsigned astc_subset(std::uint32_t seed, unsigned x, unsigned y, unsigned subsets) {
  x <<= 1, y <<= 1;
  std::uint32_t r = seed + (subsets - 1) * 1024;
  r ^= r >> 15, r -= r << 17, r += r << 7, r += r << 4, r ^= r >> 5, r += r << 16;
  r ^= r >> 7, r ^= r >> 3, r ^= r << 6, r ^= r >> 17;
  unsigned s[6];
  for (unsigned i = 0; i < 6; ++i) s[i] = (r >> (4 * i) & 15) * (r >> (4 * i) & 15);
  seed += (subsets - 1) * 1024;
  const unsigned sh1 = seed & 1 ? (seed & 2 ? 4 : 5) : (subsets == 3 ? 6 : 5);
  const unsigned sh2 = seed & 1 ? (subsets == 3 ? 6 : 5) : (seed & 2 ? 4 : 5);
  for (unsigned i = 0; i < 6; ++i) s[i] >>= i % 2 == 0 ? sh1 : sh2;
  const unsigned a = (s[0] * x + s[1] * y + (r >> 14)) & 63, b = (s[2] * x + s[3] * y + (r >> 10)) & 63;
  const unsigned c = subsets < 3 ? 0 : (s[4] * x + s[5] * y + (r >> 6)) & 63;
  return a >= b && a >= c ? 0 : b >= c ? 1 : 2;
}

TEST(Uastc, PatternsAreThoseOfAstc) {
  const std::vector<std::uint32_t> two = {28,  20,  16,  29,  91,  9,   107, 72,  149, 204,
                                          50,  114, 496, 17,  78,  39,  252, 828, 43,  156,
                                          116, 210, 476, 273, 684, 359, 246, 195, 694, 524},
                                   three = {260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254};
  const auto expect_pattern = [](unsigned mode, std::size_t index, std::uint32_t seed, unsigned subsets) {
    for (unsigned i = 0; i < 16; ++i)
      EXPECT_EQ(uastc_pattern(mode, index) >> (2 * i) & 3, astc_subset(seed, i % 4, i / 4, subsets))
          << mode << " " << index << " " << i;
  };
  ASSERT_EQ(uastc_pattern_count(2), two.size());
  for (std::size_t i = 0; i < two.size(); ++i) expect_pattern(2, i, two[i], 2);
  ASSERT_EQ(uastc_pattern_count(3), three.size());
  for (std::size_t i = 0; i < three.size(); ++i) expect_pattern(3, i, three[i], 3);
  // Those of mode 7 are some of ASTC's too.
  for (std::size_t i = 0; i < uastc_pattern_count(7); ++i) {
    bool known = false;
    for (std::uint32_t seed = 0; seed < 1024 && !known; ++seed) {
      std::uint32_t pattern = 0;
      for (unsigned t = 0; t < 16; ++t) pattern |= astc_subset(seed, t % 4, t / 4, 2) << (2 * t);
      known = pattern == uastc_pattern(7, i);
    }
    EXPECT_TRUE(known) << i;
  }
}

}  // namespace
}  // namespace furnace
