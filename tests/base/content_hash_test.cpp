#include "renderer/base/content_hash.hpp"

#include "renderer/base/blob.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <unordered_set>

namespace furnace {
namespace {

std::string hex_of(const std::string& text) {
  return hash_bytes(std::as_bytes(std::span(text))).hex();
}

// FIPS 180-4 examples (NIST CSRC, "SHA256.pdf" and the one-million-a vector).
TEST(ContentHash, IsSha256) {
  EXPECT_EQ(hex_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hex_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hex_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hex_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(ContentHash, OrdersByBytesAndHashesForMaps) {
  const ContentHash a = hash_bytes({}), b = hash_bytes(std::as_bytes(std::span("x", 1)));
  EXPECT_NE(a, b);
  EXPECT_EQ(a < b, a.hex() < b.hex());
  EXPECT_EQ((std::unordered_set<ContentHash>{a, b, a}.size()), 2u);
}

ContentHash of(auto... fields) {
  HashBuilder builder;
  (builder.add(fields), ...);
  return builder.finish();
}

using namespace std::string_view_literals;

TEST(HashBuilder, KeepsFieldsApart) {
  EXPECT_NE(of("ab"sv, "c"sv), of("a"sv, "bc"sv));
  EXPECT_NE(of("ab"sv), of("a"sv, "b"sv));
  EXPECT_NE(of(""sv), of());
  EXPECT_EQ(of("a"sv, std::int64_t{7}), of("a"sv, std::int64_t{7}));
}

TEST(HashBuilder, KeepsTypesApart) {
  const std::string eight(8, '\0');
  const ContentHash zero{};
  const std::string thirty_two(32, '\0');
  EXPECT_NE(of(std::int64_t{0}), of(0.0));
  EXPECT_NE(of(std::int64_t{0}), of(std::string_view(eight)));
  EXPECT_NE(of(std::string_view(eight)), of(std::as_bytes(std::span(eight))));
  EXPECT_NE(of(zero), of(std::as_bytes(std::span(thirty_two))));
}

TEST(HashBuilder, TakesRealNumbersByValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(of(0.0), of(-0.0));
  EXPECT_EQ(of(nan), of(std::copysign(nan, -1.0)));
  EXPECT_NE(of(1.0), of(std::nextafter(1.0, 2.0)));
  EXPECT_NE(of(1.0), of(-1.0));
}

// Keys name files that outlive a build: a change of the encoding must be seen.
TEST(HashBuilder, EncodesAsItAlwaysDid) {
  EXPECT_EQ(of("furnace"sv, std::int64_t{-2}, 0.5).hex(),
            hex_of(std::string("t\x07\0\0\0\0\0\0\0furnace"
                               "i\x08\0\0\0\0\0\0\0\xfe\xff\xff\xff\xff\xff\xff\xff"
                               "d\x08\0\0\0\0\0\0\0\0\0\0\0\0\0\xe0\x3f",
                               9 + 7 + 9 + 8 + 9 + 8)));
}

TEST(HashBuilderDeathTest, FinishesOnce) {
  HashBuilder builder;
  builder.finish();
  EXPECT_DEATH(builder.finish(), "FURNACE_CHECK");
}

TEST(Blob, SharesItsBytesWithItsParts) {
  Blob part;
  {
    const Blob whole(std::string("hello world"));
    part = Blob::slice(whole, 6, 5);
    EXPECT_EQ(part.bytes().data(), whole.bytes().data() + 6);
  }
  EXPECT_EQ(part.text(), "world");
  EXPECT_EQ(part.hash(), Blob(std::string("world")).hash());
}

TEST(Blob, IsEmptyByDefault) {
  EXPECT_TRUE(Blob().empty());
  EXPECT_EQ(Blob::slice(Blob(std::string("x")), 1, 0).size(), 0u);
}

TEST(BlobDeathTest, RefusesAPartBeyondItsEnd) {
  const Blob whole(std::string("hello"));
  EXPECT_DEATH(Blob::slice(whole, 3, 3), "bytes 3 \\+ 3 of 5");
  EXPECT_DEATH(Blob::slice(whole, 1, std::numeric_limits<std::size_t>::max()), "of 5");
}

}  // namespace
}  // namespace furnace
