#include "api/document.hpp"

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"

namespace furnace::api {
namespace {

Error parse_error(std::string_view text, const JsonLimits& limits = {}) {
  try {
    Document::parse(text, limits);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "accepted: " << text;
  return {};
}

TEST(Document, ValuesKnowTheirTypesAndPlaces) {
  const Document document = Document::parse(R"({"a/b":[1,2.5,"x",true,null,{"~":3.0}]})", {});
  const Value list = document.root()["a/b"];
  EXPECT_EQ(list.pointer(), "/a~1b");
  EXPECT_EQ(list.size(), 6u);
  EXPECT_EQ(list.at(0).type(), JsonType::kInteger);
  EXPECT_EQ(list.at(1).type(), JsonType::kNumber);
  EXPECT_EQ(list.at(2).text(), "x");
  EXPECT_TRUE(list.at(3).boolean());
  EXPECT_EQ(list.at(4).type(), JsonType::kNull);
  EXPECT_EQ(list.at(5)["~"].pointer(), "/a~1b/5/~0");
  EXPECT_EQ(list.at(5)["~"].type(), JsonType::kInteger) << "3.0 is a whole number";
  EXPECT_EQ(list.at(6).type(), JsonType::kAbsent);
}

TEST(Document, AbsentPlacesKnowTheirPointer) {
  const Document document = Document::parse(R"({"a":1})", {});
  const Value absent = document.root()["b"]["c"].at(2);
  EXPECT_FALSE(absent);
  EXPECT_EQ(absent.pointer(), "/b/c/2");
  EXPECT_FALSE(document.root()["a"]["c"]);
  EXPECT_FALSE(document.root()["a"].at(0));
}

TEST(Document, DuplicateKeysAreRefusedWithTheirPlace) {
  EXPECT_EQ(parse_error(R"({"a":1,"b":2,"a":3})").pointer, "/a");
  const Error error = parse_error(R"({"x":[{},{"k":{"a/b":1,"a/b":1}}]})");
  EXPECT_EQ(error.code, ErrorCode::kInvalidRequest);
  EXPECT_EQ(error.pointer, "/x/1/k/a~1b");
  EXPECT_EQ(parse_error(R"({"":1,"":2})").pointer, "/");
  EXPECT_EQ(parse_error(R"({"\u0061":1,"a":2})").pointer, "/a") << "keys compare after their escapes";
}

TEST(Document, DepthIsCountedInContainers) {
  const JsonLimits limits{3, 1000};
  EXPECT_NO_THROW(Document::parse(R"([{"a":[]}])", limits));
  const Error error = parse_error(R"([0,{"a":[[]]}])", limits);
  EXPECT_EQ(error.code, ErrorCode::kInvalidRequest);
  EXPECT_EQ(error.pointer, "/1/a/0");
}

TEST(Document, SizeIsCheckedBeforeReading) {
  EXPECT_NO_THROW(Document::parse("[1]", {8, 3}));
  EXPECT_EQ(parse_error("[11]", {8, 3}).code, ErrorCode::kTooLarge);
}

TEST(Document, LongKeysAreRefused) {
  const std::string key(2000, 'k');
  EXPECT_EQ(parse_error(R"({"a":{")" + key + R"(":1}})").pointer, "/a");
}

TEST(Document, NumbersBeyondDoubleAreRefused) {
  for (const std::string_view number : {"1e999", "-1e400", "[1,1e309]"})
    EXPECT_EQ(parse_error(number).code, ErrorCode::kInvalidRequest) << number;
  EXPECT_EQ(parse_error(R"({"a":[1,1e309]})").pointer, "/a/1");
  EXPECT_EQ(Document::parse("1e-999", {}).root().number(), 0);
}

TEST(Document, NumbersKeepTheirValue) {
  EXPECT_EQ(Document::parse("18446744073709551615", {}).root().number(), 18446744073709551616.0);
  EXPECT_EQ(Document::parse("9223372036854775807", {}).root().type(), JsonType::kInteger);
  EXPECT_EQ(Document::parse("-7.0", {}).root().integer(), -7);
  EXPECT_EQ(Document::parse("0.1", {}).root().number(), 0.1);
}

TEST(Document, BytesThatAreNotUtf8AreRefused) {
  for (const std::string_view bytes : {"\"\xFF\"", "\"\xC0\x80\"", "\"\xED\xA0\x80\"", "{\"\xE2\x28\":1}"})
    EXPECT_EQ(parse_error(bytes).code, ErrorCode::kInvalidRequest);
  EXPECT_EQ(Document::parse("\"\xE2\x82\xAC\"", {}).root().text(), "€");
}

TEST(Document, NothingFollowsTheValue) {
  using namespace std::string_view_literals;
  for (const std::string_view text :
       {"{} x"sv, "{}\0"sv, "{}\0{}"sv, "[1]2"sv, "NaN"sv, "{,}"sv, "// c\n{}"sv, ""sv})
    EXPECT_EQ(parse_error(text).code, ErrorCode::kInvalidRequest);
}

TEST(Document, SyntaxErrorsSayWhere) {
  const Error error = parse_error("{\n  \"output\": {\"width\": 12,\n  height: 3}\n}");
  EXPECT_EQ(error.pointer, "/output");
  EXPECT_NE(error.message.find("line 3, column 3"), std::string::npos) << error.message;
  EXPECT_NE(parse_error("{\"a\":").message.find("too early"), std::string::npos);
}

TEST(Document, ExcerptsAreShortAndWhole) {
  const Document document = Document::parse(R"(["short",[1],{},1.5,")" + std::string(500, 'a') + "\"]", {});
  EXPECT_EQ(document.root().at(0).excerpt(), "\"short\"");
  EXPECT_EQ(document.root().at(1).excerpt(), "an array of 1 item");
  EXPECT_EQ(document.root().at(2).excerpt(), "an object");
  EXPECT_EQ(document.root().at(3).excerpt(), "1.5");
  EXPECT_LT(document.root().at(4).excerpt().size(), 80u);
  EXPECT_EQ(quoted("ab€€", 4), "\"ab…\"") << "a character is not divided";
  EXPECT_EQ(quoted("a\"b\n", 60), R"("a\"b\n")");
}

}  // namespace
}  // namespace furnace::api
