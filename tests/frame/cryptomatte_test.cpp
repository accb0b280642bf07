// Names, numbers and cover of mattes.
#include <bit>
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/frame/cryptomatte.hpp"

namespace furnace {
namespace {

// Vectors of Appleby's reference implementation.
TEST(Cryptomatte, HashesAsTheReferenceDoes) {
  EXPECT_EQ(murmur3_32(""), 0u);
  EXPECT_EQ(murmur3_32("", 1), 0x514e28b7u);
  EXPECT_EQ(murmur3_32("", 0xffffffffu), 0x81f16f39u);
  EXPECT_EQ(murmur3_32(std::string_view("\0\0\0\0", 4)), 0x2362f9deu);
  EXPECT_EQ(murmur3_32("aaaa", 0x9747b28cu), 0x5a97808au);
  EXPECT_EQ(murmur3_32("aaa", 0x9747b28cu), 0x283e0130u);
  EXPECT_EQ(murmur3_32("aa", 0x9747b28cu), 0x5d211726u);
  EXPECT_EQ(murmur3_32("a", 0x9747b28cu), 0x7fa09ea6u);
  EXPECT_EQ(murmur3_32("Hello, world!", 0x9747b28cu), 0x24884cbau);
  EXPECT_EQ(murmur3_32("The quick brown fox jumps over the lazy dog", 0x9747b28cu), 0x2fa826cdu);
}

TEST(Cryptomatte, NumbersAreNormalFloats) {
  for (int i = 0; i < 20'000; ++i) {
    const float id = matte_id("name " + std::to_string(i));
    ASSERT_TRUE(std::isnormal(id)) << i;
  }
  // Its hash is 0, whose exponent is none of a normal float.
  EXPECT_EQ(std::bit_cast<std::uint32_t>(matte_id("")), 1u << 23);
}

TEST(Cryptomatte, ManifestNamesEachOnce) {
  const std::vector<std::string> names = {"bunny", "a \"b\"\\\n", "bunny"};
  const auto fields = matte_attributes("cryptoObject", names);
  ASSERT_EQ(fields.size(), 4u);
  EXPECT_EQ(fields[0].value, "cryptoObject");
  EXPECT_EQ(fields[1].value, "MurmurHash3_32");
  EXPECT_EQ(fields[2].value, "uint32_to_float32");
  // 13851a76 is what the specification states for "bunny".
  EXPECT_TRUE(fields[3].value.starts_with(R"({"bunny":"13851a76","a \"b\"\\\u000a":")")) << fields[3].value;
  EXPECT_EQ(fields[3].value.find("bunny", 10), std::string::npos);
  for (const TextField& field : fields) {
    EXPECT_TRUE(field.key.starts_with("cryptomatte/"));
    EXPECT_EQ(field.key.find('/', 12), 12u + 7);
  }
  EXPECT_NE(fields[0].key, matte_attributes("cryptoMaterial", names)[0].key);
}

TEST(Cryptomatte, CoverIsCountedAndRanked) {
  MatteTile tile({2, 1});
  const std::vector<float> ids = {0, 10, 20, 30};
  // Samples of two pixels, row by row.
  const std::vector<std::uint32_t> first = {1, 2, 0, 3, 2, 2, 3, 3}, second = {2, 2, 3, 3, 2, 2, 3, 0};
  tile.add(first, ids, 0.75f);
  tile.add(second, ids, 0.25f);
  const auto left = tile.ranks(0, 0);
  EXPECT_EQ(left[0].id, 20);
  EXPECT_FLOAT_EQ(left[0].cover, 0.75f * 0.75f + 0.25f);
  EXPECT_EQ(left[1].id, 10);
  EXPECT_FLOAT_EQ(left[1].cover, 0.75f * 0.25f);
  EXPECT_EQ(left[2].cover, 0);
  const auto right = tile.ranks(1, 0);
  EXPECT_EQ(right[0].id, 30);
  EXPECT_FLOAT_EQ(right[0].cover, 0.75f * 0.75f + 0.25f * 0.75f);
}

TEST(Cryptomatte, CrowdsKeepTheSixLargest) {
  MatteTile tile({1, 1});
  std::vector<float> ids = {0};
  for (int i = 1; i <= 12; ++i) ids.push_back(float(i));
  for (std::uint32_t key = 1; key <= 12; ++key)
    tile.add(std::vector<std::uint32_t>(4, key), ids, key == 7 ? 0.5f : 1 / 22.f);
  const auto ranks = tile.ranks(0, 0);
  EXPECT_EQ(ranks[0].id, 7);
  EXPECT_FLOAT_EQ(ranks[0].cover, 0.5f);
  for (const auto& rank : ranks) EXPECT_GT(rank.cover, 0);
}

// A filter's negative weights can leave less than nothing of one.
TEST(Cryptomatte, NothingNegativeIsKept) {
  MatteTile tile({1, 1});
  const std::vector<float> ids = {0, 5, 6};
  tile.add(std::vector<std::uint32_t>(4, 1), ids, 1.1f);
  tile.add(std::vector<std::uint32_t>(4, 2), ids, -0.1f);
  const auto ranks = tile.ranks(0, 0);
  EXPECT_EQ(ranks[0].id, 5);
  EXPECT_EQ(ranks[1].id, 0);
}

}  // namespace
}  // namespace furnace
