#include "server/url_signature.hpp"

#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "server/crypto.hpp"
#include "server/key_lines.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const UrlKey kKey{"k1", "0123456789abcdef0123456789abcdef"};
const UrlSignatures kSignatures{{kKey, {"k2", std::string(16, '\x80')}}};
constexpr std::int64_t kNow = 1'800'000'000;

std::string query_of(const std::string& url) {
  return url.substr(url.find('?') + 1);
}

// RFC 4231 sections 4.2, 4.3 and 4.7.
TEST(Crypto, HmacOfTheRfc) {
  EXPECT_EQ(hex_of_bytes(hmac_sha256(std::string(20, '\x0b'), "Hi There")),
            "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(hex_of_bytes(hmac_sha256("Jefe", "what do ya want for nothing?")),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(hex_of_bytes(hmac_sha256(std::string(131, '\xaa'),
                                     "Test Using Larger Than Block-Size Key - Hash Key First")),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

TEST(Crypto, ComparisonAndRandomness) {
  EXPECT_TRUE(equal_in_constant_time("abc", "abc"));
  EXPECT_FALSE(equal_in_constant_time("abc", "abd"));
  EXPECT_FALSE(equal_in_constant_time("abc", "ab"));
  EXPECT_TRUE(equal_in_constant_time("", ""));
  EXPECT_EQ(random_bytes(32).size(), 32u);
  EXPECT_NE(random_bytes(32), random_bytes(32));
}

// The vector that README.md tells; another implementation made it (openssl dgst -sha256 -hmac).
TEST(UrlSignature, AVectorForOtherImplementations) {
  const auto pairs = parse_query("model=file:a+b%2eglb&width=640&kid=k1&exp=1800000060&sig=ignored");
  EXPECT_EQ(canonical_text(*pairs),
            "GET\n/v1/render\nmodel=file%3Aa%20b.glb&width=640&kid=k1&exp=1800000060");
  const std::string url = signed_url(*parse_query("model=file:a+b.glb&width=640"), kKey, 1'800'000'060);
  EXPECT_EQ(url,
            "/v1/render?model=file%3Aa%20b.glb&width=640&kid=k1&exp=1800000060"
            "&sig=Q7r8aac3yjsyucDWRqIsBPSAAJPbO8qgm4l6nN65uU8");
  EXPECT_EQ(kSignatures.fault(query_of(url), kNow), "");
}

TEST(UrlSignature, HoldsHoweverTheSameIsWritten) {
  const std::string sig = query_of(signed_url(*parse_query("a=x+y&b"), kKey, kNow + 60));
  const std::string tail = sig.substr(sig.find("&sig="));
  for (const std::string& same :
       {std::string("a=x%20y&b=&kid=k1&exp="), std::string("&a=x+y&&b&%6bid=k1&exp=")})
    EXPECT_EQ(kSignatures.fault(same + std::to_string(kNow + 60) + tail, kNow), "") << same;
  const std::string first = tail.substr(1) + "&a=x+y&b&kid=k1&exp=" + std::to_string(kNow + 60);
  EXPECT_EQ(kSignatures.fault(first, kNow), "") << "sig may stand anywhere";
}

TEST(UrlSignature, EveryChangeIsSeen) {
  const std::string query = query_of(signed_url(*parse_query("model=a&width=640"), kKey, kNow + 60));
  ASSERT_EQ(kSignatures.fault(query, kNow), "");
  const auto pairs = *parse_query(query);
  for (std::size_t i = 0; i < query.size(); ++i) {
    for (const char c : {'0', 'A', '_', '&', '=', '%', '+'}) {
      std::string changed = query;
      changed[i] = c;
      const auto read = parse_query(changed);
      if (changed == query || (read && canonical_query(*read) == canonical_query(pairs))) continue;
      EXPECT_NE(kSignatures.fault(changed, kNow), "") << changed;
    }
    EXPECT_NE(kSignatures.fault(query.substr(0, i), kNow), "");
  }
  EXPECT_NE(kSignatures.fault(query + "&quality=high", kNow), "");
  EXPECT_NE(kSignatures.fault("quality=high&" + query, kNow), "");
  EXPECT_NE(kSignatures.fault("width=640&model=a" + query.substr(query.find("&kid")), kNow), "")
      << "another order";
  EXPECT_NE(kSignatures.fault(query + "&sig=x", kNow), "");
  EXPECT_NE(kSignatures.fault(query + "&kid=k1", kNow), "");
  EXPECT_NE(UrlSignatures({{"k1", std::string(32, 'x')}}).fault(query, kNow), "");
}

TEST(UrlSignature, Time) {
  const auto fault_at = [](std::int64_t expires, std::int64_t now) {
    return std::string(kSignatures.fault(query_of(signed_url({}, kKey, expires)), now));
  };
  EXPECT_EQ(fault_at(kNow + 1, kNow), "");
  EXPECT_THAT(fault_at(kNow, kNow), HasSubstr("expired"));
  EXPECT_THAT(fault_at(-5, kNow), HasSubstr("expired"));
  EXPECT_EQ(fault_at(kNow + kMaxUrlLifeS, kNow), "");
  EXPECT_THAT(fault_at(kNow + kMaxUrlLifeS + 1, kNow), HasSubstr("year"));
  const std::string query = query_of(signed_url({}, kKey, kNow));
  EXPECT_THAT(std::string(kSignatures.fault(
                  "kid=k1&exp=" + std::to_string(kNow + 9) + query.substr(query.find("&sig")), kNow)),
              HasSubstr("does not fit"));
}

TEST(UrlSignature, AnEndThatIsNoNumber) {
  for (const char* end : {"", "soon", "1e9", " 1", "99999999999999999999", "1800000060x"}) {
    std::vector<api::QueryPair> pairs = {{"kid", "k1"}, {"exp", end}};
    pairs.push_back({"sig", base64url(hmac_sha256(kKey.secret, canonical_text(pairs)))});
    EXPECT_NE(kSignatures.fault(canonical_query(pairs), kNow), "") << end;
  }
}

TEST(UrlSignature, WhatIsSignedMayNotBringItsOwn) {
  for (const char* name : {"kid", "exp", "sig"}) EXPECT_THROW(signed_url({{name, "1"}}, kKey, kNow), Error);
}

TEST(UrlKeys, SeveralForRotation) {
  const auto keys =
      parse_url_keys("# comment\n\nold:000102030405060708090a0b0c0d0e0f\r\nnew.1:" + std::string(64, 'F'));
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].id, "old");
  EXPECT_EQ(hex_of_bytes(keys[0].secret), "000102030405060708090a0b0c0d0e0f");
  EXPECT_EQ(keys[1].id, "new.1");
  EXPECT_EQ(keys[1].secret, std::string(32, '\xff'));
}

TEST(UrlKeys, AllProblemsAndNoSecretInThem) {
  const std::string secret(32, 'e');
  try {
    parse_url_keys("a:" + secret + "\na:" + secret + "\nb\nc:12\nd:" + secret + "g0\n:" + secret +
                   "\ne:" + secret + ":1\n");
    FAIL() << "it was taken";
  } catch (const Error& error) {
    std::vector<std::string> places;
    for (const Problem& problem : error.problems) {
      places.push_back(problem.pointer);
      EXPECT_THAT(problem.message, Not(HasSubstr(secret)));
    }
    EXPECT_THAT(places, ElementsAre("line 2", "line 3", "line 4", "line 5", "line 6", "line 7"));
  }
  EXPECT_THROW(parse_url_keys(""), Error);
  EXPECT_THROW(parse_url_keys("# nothing\n"), Error);
}

TEST(UrlKeys, Garbage) {
  std::mt19937 random(4);
  const std::string alphabet = "ab0f:#\n\r\xff ,";
  for (int i = 0; i < 5000; ++i) {
    std::string text(random() % 80, ' ');
    for (char& c : text) c = alphabet[random() % alphabet.size()];
    try {
      parse_url_keys(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    }
  }
}

TEST(UrlSignature, Garbage) {
  std::mt19937 random(5);
  const std::string alphabet = "kidexpsg=&%12\xff+_A";
  for (int i = 0; i < 20'000; ++i) {
    std::string query(random() % 60, ' ');
    for (char& c : query) c = alphabet[random() % alphabet.size()];
    EXPECT_NE(kSignatures.fault(query, kNow), "");
  }
}

}  // namespace
}  // namespace furnace
