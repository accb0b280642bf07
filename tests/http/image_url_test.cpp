#include "server/image_url.hpp"

#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "api/document.hpp"
#include "api/problem.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string text_of(std::string_view query, const Presets& presets = {}, const ImageUrlConfig& config = {}) {
  return document_of_query(query, presets, config, {}).text;
}

Error refusal_of(std::string_view query, const Presets& presets = {}, const ImageUrlConfig& config = {}) {
  try {
    text_of(query, presets, config);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << query << " was taken";
  return {};
}

void expect_same_json(std::string_view a, std::string_view b) {
  EXPECT_TRUE(api::Document::parse(a, {}).root() == api::Document::parse(b, {}).root()) << a << "\n" << b;
}

// RFC 4648 section 10, in the URL's alphabet.
TEST(Base64Url, VectorsAndBytesThatNeedTheAlphabet) {
  const std::pair<std::string, std::string> rows[] = {
      {"", ""},           {"f", "Zg"},          {"fo", "Zm8"},          {"foo", "Zm9v"},
      {"foob", "Zm9vYg"}, {"fooba", "Zm9vYmE"}, {"foobar", "Zm9vYmFy"}, {"\xfb\xff\xfe", "-__-"}};
  for (const auto& [bytes, text] : rows) {
    EXPECT_EQ(base64url(bytes), text);
    EXPECT_EQ(base64url_decoded(text), bytes);
    EXPECT_EQ(base64url_decoded(text + std::string((4 - text.size() % 4) % 4, '=')), bytes);
  }
  for (const char* wrong :
       {"Z", "Zg=", "Zg===", "Zh", "Zm9", "Zm+v", "Zm/v", "Zm9v=", "Zm9vYg=", "Z g", "=", "====", "Zm9v\n"})
    EXPECT_EQ(base64url_decoded(wrong), std::nullopt) << wrong;
}

TEST(Base64Url, WhatIsReadIsWhatIsWritten) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string bytes(random() % 40, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    EXPECT_EQ(base64url_decoded(base64url(bytes)), bytes);
    std::string text = base64url(bytes);
    for (char& c : text)
      if (random() % 16 == 0) c = static_cast<char>(random());
    const auto read = base64url_decoded(text);
    if (read) {
      EXPECT_EQ(base64url(*read), text.substr(0, text.find('=')));
    }
  }
}

TEST(UrlQuery, PairsAsBrowsersWriteThem) {
  const auto pairs = parse_query("a=1&b=%41+%2b&&c&=d&e=f=g&%26=%3D");
  ASSERT_TRUE(pairs);
  std::vector<std::string> told;
  for (const auto& pair : *pairs) told.push_back(pair.name + "|" + pair.value);
  EXPECT_THAT(told, ElementsAre("a|1", "b|A +", "c|", "|d", "e|f=g", "&|="));
  EXPECT_EQ(canonical_query(*pairs), "a=1&b=A%20%2B&c=&=d&e=f%3Dg&%26=%3D");
  for (const char* wrong : {"%", "a=%", "a=%4", "a=%4g", "a%zz=1", "a=%%41"})
    EXPECT_EQ(parse_query(wrong), std::nullopt) << wrong;
}

TEST(UrlQuery, TheCanonicalTextIsItsOwn) {
  std::mt19937 random(2);
  const std::string alphabet = "ab&=%+41f \xc3\xa9~/";
  int read = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string query(random() % 24, ' ');
    for (char& c : query) c = alphabet[random() % alphabet.size()];
    const auto pairs = parse_query(query);
    if (!pairs) continue;
    ++read;
    const std::string canonical = canonical_query(*pairs);
    EXPECT_EQ(canonical_query(*parse_query(canonical)), canonical);
  }
  EXPECT_GT(read, 1000);
}

TEST(ImageUrl, EveryKeyLandsAtItsPlace) {
  std::set<std::string_view> names, pointers;
  for (const api::QueryKey& key : api::query_keys()) {
    SCOPED_TRACE(key.name);
    EXPECT_TRUE(names.insert(key.name).second);
    EXPECT_TRUE(pointers.insert(key.pointer).second);
    const bool is_number = key.kind == api::QueryKind::kNumber, is_flag = key.kind == api::QueryKind::kFlag;
    const std::string value = is_flag                             ? "true"
                              : is_number                         ? "2"
                              : key.kind == api::QueryKind::kText ? "x"
                                                                  : "1,2,3";
    const std::string text = text_of(std::string(key.name) + "=" + value);
    std::string expected = is_flag || is_number                ? value
                           : key.kind == api::QueryKind::kText ? "\"x\""
                                                               : "[1,2,3]";
    std::string_view pointer = key.pointer;
    while (!pointer.empty()) {
      const std::size_t slash = pointer.rfind('/');
      const std::string token(pointer.substr(slash + 1));
      expected = token == "0" ? "[" + expected + "]" : "{\"" + token + "\":" + expected + "}";
      pointer = pointer.substr(0, slash);
    }
    expect_same_json(text, expected);
  }
}

TEST(ImageUrl, AnEmptyQueryIsAnEmptyDocument) {
  EXPECT_EQ(text_of(""), "{}");
  EXPECT_EQ(text_of("&&"), "{}");
  EXPECT_EQ(text_of("kid=a&exp=1&sig=x"), "{}") << "signatures are looked at elsewhere";
}

TEST(ImageUrl, FlatKeysGoOverTheDocument) {
  const std::string document =
      R"({"output":{"width":1,"height":2},"scene":{"nodes":[{"mesh":"builtin:cube","scale":[1,2,3]}]}})";
  expect_same_json(text_of("width=7&material=gold&r=" + base64url(document)),
                   R"({"output":{"width":7,"height":2},
                       "scene":{"nodes":[{"mesh":"builtin:cube","material":"gold","scale":[1,2,3]}]}})");
  expect_same_json(text_of("model=file:a%20b.glb&eye=1,-2.5e-1,0&ground=false"),
                   R"({"scene":{"model":"file:a b.glb"},"camera":{"lookAt":{"eye":[1,-0.25,0]}},
                       "environment":{"ground":{"shadow":false}}})");
}

TEST(ImageUrl, NumbersAreJsonNumbers) {
  for (const char* wrong : {"",   "+1", "01",  ".5",  "5.", "1e",  "1e999", "0x1",  "nan", "inf",
                            "1 ", " 1", "1,2", "--1", "-",  "1_0", "true",  "null", "[1]", "1%00"}) {
    const Error error = refusal_of(std::string("width=") + wrong);
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable) << wrong;
    EXPECT_EQ(error.pointer, "?width") << wrong;
  }
  for (const char* wrong : {"", ",", "1,", ",1", "1,,2", "1,a,2", "1,2,3,4,5"})
    EXPECT_EQ(refusal_of(std::string("eye=") + wrong).pointer, "?eye");
  for (const char* wrong : {"", "1", "yes", "True"})
    EXPECT_EQ(refusal_of(std::string("strict=") + wrong).pointer, "?strict");
  for (const char* wrong : {"%ff", "%c3", "a%00b", "%ed%a0%80"})
    EXPECT_EQ(refusal_of(std::string("model=") + wrong).pointer, "?model");
}

TEST(ImageUrl, AllProblemsAtTheirKeys) {
  const Error error = refusal_of("widht=1&height=x&strict=maybe&width=3");
  ASSERT_EQ(error.problems.size(), 3u);
  EXPECT_EQ(error.problems[0].pointer, "?widht");
  EXPECT_THAT(error.problems[0].message, HasSubstr("did you mean"));
  EXPECT_EQ(error.problems[1].pointer, "?height");
  EXPECT_EQ(error.problems[2].pointer, "?strict");
  EXPECT_EQ(refusal_of("width=1&width=1").code, ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("width=%").code, ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("r=%25").pointer, "?r");
  EXPECT_EQ(refusal_of("r=e30&preset=a").pointer, "?r");
  EXPECT_EQ(refusal_of("r=" + base64url("{")).code, ErrorCode::kInvalidRequest);
  EXPECT_EQ(refusal_of("width=1&r=" + base64url("[]")).pointer, "?width");
  EXPECT_EQ(refusal_of("width=1&r=" + base64url(R"({"output":5})")).pointer, "?width");
  EXPECT_EQ(refusal_of("mesh=x&r=" + base64url(R"({"scene":{"nodes":{}}})")).pointer, "?mesh");
}

TEST(ImageUrl, ProblemsOfTheDocumentAreToldAtTheKeyThatWroteThem) {
  const std::vector<api::QueryPair> pairs = {{"width", "0"}, {"eye", "1"}};
  Error error{ErrorCode::kUnprocessable,
              "2 problems, the first at /output/width: too small",
              "/output/width",
              {},
              {},
              {}};
  error.problems = {{"/output/width", "too small"},
                    {"/camera/lookAt/eye/0", "no"},
                    {"/output/widths", "x"},
                    {"/scene", "y"}};
  api::point_at_query(error, pairs);
  EXPECT_EQ(error.pointer, "?width");
  EXPECT_EQ(error.problems[0].pointer, "?width");
  EXPECT_EQ(error.problems[1].pointer, "?eye");
  EXPECT_EQ(error.problems[2].pointer, "/output/widths");
  EXPECT_EQ(error.problems[3].pointer, "/scene");
  EXPECT_THAT(error.message, HasSubstr("the first at ?width: too small"));
}

TEST(ImageUrl, GarbageIsRefusedOrADocument) {
  std::mt19937 random(3);
  std::vector<std::string> keys = {"r", "preset", "sig"};
  for (const api::QueryKey& key : api::query_keys()) keys.emplace_back(key.name);
  const std::string alphabet = "01,.-+eE%41truefalsgZ_=&\xff{}\"";
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string query;
    for (auto pairs = random() % 3 + 1; pairs > 0; --pairs) {
      query += keys[random() % keys.size()] + "=";
      for (auto length = random() % 6; length > 0; --length) query += alphabet[random() % alphabet.size()];
      query += '&';
    }
    try {
      api::Document::parse(text_of(query), {});
      ++taken;
    } catch (const Error& error) {
      EXPECT_NE(error.code, ErrorCode::kInternal) << query;
    }
  }
  EXPECT_GT(taken, 1000);
}

class PresetsTest : public ::testing::Test {
 protected:
  ~PresetsTest() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  Presets read() const { return Presets(folder_, {}); }

  const std::filesystem::path folder_ = [] {
    const auto folder =
        std::filesystem::path(::testing::TempDir()) /
        (std::string("presets_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder);
    return folder;
  }();
};

TEST_F(PresetsTest, TheirNamesAndWhatTheyOpen) {
  write("shop.v2.json", R"({"furnace:open":["width","model"],"output":{"height":5}})");
  write("plain.json", "{}");
  write("notes.txt", "nothing");
  const Presets presets = read();
  expect_same_json(presets.names_json(),
                   R"({"presets":[{"name":"plain","open":[]},{"name":"shop.v2","open":["width","model"]}]})");
  expect_same_json(text_of("preset=shop.v2&width=7&fov=20", presets),
                   R"({"output":{"height":5,"width":7},"camera":{"fovYDegrees":20}})");
  EXPECT_EQ(refusal_of("preset=other", presets).code, ErrorCode::kNotFound);
  EXPECT_EQ(refusal_of("preset=../plain", presets).pointer, "?preset");
}

TEST_F(PresetsTest, OnlyWhatAPresetOpens) {
  write("shop.json", R"({"furnace:open":["width"],"output":{"height":5}})");
  const Presets presets = read();
  const ImageUrlConfig only{3600, true};
  expect_same_json(text_of("preset=shop&width=7&kid=a&exp=1&sig=b", presets, only),
                   R"({"output":{"height":5,"width":7}})");
  EXPECT_EQ(refusal_of("preset=shop&height=7", presets, only).pointer, "?height");
  EXPECT_EQ(refusal_of("width=7", presets, only).pointer, "?preset");
  EXPECT_EQ(refusal_of("r=e30", presets, only).pointer, "?preset");
  EXPECT_EQ(refusal_of("", presets, only).pointer, "?preset");
}

TEST_F(PresetsTest, AllProblemsOfAllFiles) {
  write("a.json", R"({"furnace:open":["widht",3],"output":{"width":0}})");
  write("b.json", "{");
  write("c.json", R"({"furnace:open":"width"})");
  write("d e.json", "{}");
  write("f.json", R"({"scene":{"furnace:open":[]}})");
  try {
    read();
    FAIL() << "they were taken";
  } catch (const Error& error) {
    std::vector<std::string> places;
    for (const Problem& problem : error.problems) places.push_back(problem.pointer);
    EXPECT_THAT(places,
                ElementsAre("a.json/furnace:open/0", "a.json/furnace:open/1", "a.json/output/width", "b.json",
                            "c.json/furnace:open", "d e.json", "f.json/scene/furnace:open"));
  }
}

}  // namespace
}  // namespace furnace
