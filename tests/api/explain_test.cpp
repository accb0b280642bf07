#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/api/request_fixture.hpp"

namespace furnace::api {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

std::vector<Problem> problems_of(std::string_view json) {
  return request_schema().problems(Document::parse(json, {}));
}

auto at(std::string_view pointer, std::string_view message) {
  return testing::AllOf(Field(&Problem::pointer, std::string(pointer)),
                        Field(&Problem::message, HasSubstr(std::string(message))));
}

TEST(Explain, SaysEachKindOfProblemInItsOwnWords) {
  EXPECT_THAT(problems_of("[]"), ElementsAre(at("", "must be an object, got an array of 0 items")));
  EXPECT_THAT(problems_of(R"({"output":{"width":0}})"),
              ElementsAre(at("/output/width", "must be between 1 and 16384, got 0")));
  EXPECT_THAT(problems_of(R"({"output":{"width":"wide"}})"),
              ElementsAre(at("/output/width", "must be a whole number, got \"wide\"")));
  EXPECT_THAT(problems_of(R"({"output":{"width":1.5}})"),
              ElementsAre(at("/output/width", "must be a whole number, got 1.5")));
  EXPECT_THAT(problems_of(R"({"output":{"format":"PNG"}})"),
              ElementsAre(at(
                  "/output/format",
                  R"(must be one of "png", "exr", "jpeg", "webp", "webm"; got "PNG"; did you mean "png"?)")));
  EXPECT_THAT(problems_of(R"({"camera":{"lookAt":{"eye":[1,2]}}})"),
              ElementsAre(at("/camera/lookAt/eye", "must have 3 items, got 2")));
  EXPECT_THAT(problems_of(R"({"scene":{"materials":{"m":{"baseColor":[1]}}}})"),
              ElementsAre(at("/scene/materials/m/baseColor", "must have 3 to 4 items, got 1")));
  EXPECT_THAT(problems_of(R"({"scene":{"model":""}})"),
              ElementsAre(at("/scene/model", "must have at least 1 character, got 0")));
  EXPECT_THAT(problems_of(R"({"camera":{"lookAt":{}}})"),
              ElementsAre(at("/camera/lookAt", "needs the key \"eye\"")));
  EXPECT_THAT(problems_of(R"({"environment":{"map":1}})"),
              ElementsAre(at("/environment/map", "must be a string or an object, got 1")));
  EXPECT_THAT(problems_of(R"({"scene":{"materials":{"m":"gld"}}})"),
              ElementsAre(at("/scene/materials/m", "did you mean \"gold\"?")));
  EXPECT_THAT(problems_of(R"({"strict":1})"), ElementsAre(at("/strict", "must be true or false, got 1")));
}

TEST(Explain, UnknownKeysNameTheAllowedOnes) {
  EXPECT_THAT(problems_of(R"({"outptu":{}})"),
              ElementsAre(at("/outptu",
                             "unknown key; did you mean \"output\"? (allowed here: camera, environment, "
                             "output, scene, strict)")));
  EXPECT_THAT(problems_of(R"({"camera":{"fovydegrees":3}})"),
              ElementsAre(at("/camera/fovydegrees", "did you mean \"fovYDegrees\"?")));
  EXPECT_THAT(problems_of(R"({"strict":true,"zzz":3})"),
              ElementsAre(at("/zzz", "unknown key (allowed here")));
}

TEST(Explain, ExclusionsBlameOneMember) {
  EXPECT_THAT(problems_of(R"({"camera":{"orbit":{},"lookAt":{"eye":[1,1,1]}}})"),
              ElementsAre(at("/camera/lookAt", "give one of orbit, lookAt, intrinsics and gltf")));
  EXPECT_THAT(problems_of(R"({"camera":{"gltf":0,"fovYDegrees":30}})"),
              ElementsAre(at("/camera/fovYDegrees", "a glTF camera has its own")));
  EXPECT_THAT(problems_of(R"({"output":{"quality":"high","samples":3}})"),
              ElementsAre(at("/output/samples", "give one of them")));
  EXPECT_THAT(problems_of(R"({"output":{"format":"png","exrType":"half"}})"),
              ElementsAre(at("/output/exrType", "only with")));
  EXPECT_THAT(problems_of(R"({"environment":{"background":{"color":[0,0,0]}}})"),
              ElementsAre(at("/environment/background/color", "\"type\": \"color\"")));
  EXPECT_THAT(problems_of(R"({"output":{"exrType":"half"}})"), ElementsAre()) << "Accept may ask for EXR";
}

TEST(Explain, TellsAllProblemsAtOnce) {
  EXPECT_THAT(
      problems_of(R"({"output":{"width":0,"height":-1,"x":1},"scene":{"nodes":[{"mesh":1},{}]}})"),
      ElementsAre(at("/output/height", "between"), at("/output/width", "between"), at("/output/x", "unknown"),
                  at("/scene/nodes/0/mesh", "a string"), at("/scene/nodes/1", "needs")));
}

TEST(Explain, StopsCountingAtAHundred) {
  std::string nodes = R"({"scene":{"nodes":[{})", keys = R"({"a":0)";
  for (int i = 0; i < 500; ++i) {
    nodes += ",{}";
    keys += fmt::format(R"(,"key{}":0)", i);
  }
  EXPECT_EQ(problems_of(nodes + "]}}").size(), 100u);
  EXPECT_EQ(problems_of(keys + "}").size(), 100u);
}

TEST(Explain, NearMissesOnly) {
  const std::vector<std::string> known = {"width", "height"};
  EXPECT_EQ(did_you_mean("widht", known), "; did you mean \"width\"?");
  EXPECT_EQ(did_you_mean("WIDTH", known), "; did you mean \"width\"?");
  EXPECT_EQ(did_you_mean("depth", known), "");
  EXPECT_EQ(did_you_mean("", known), "");
  EXPECT_EQ(did_you_mean(std::string(100000, 'w'), known), "");
}

// A sibling of $ref is an annotation to draft 7 and a rule to 2020-12; both must read our schema alike.
TEST(Schema, ReferencesStandBesideAnnotationsOnly) {
  const auto check = [](const auto& self, const Value& value) -> void {
    const bool is_reference = value["$ref"].type() == JsonType::kText;
    if (is_reference) {
      for (const auto& [key, member] : value.members())
        EXPECT_THAT(key, testing::AnyOf("$ref", "title", "description", "default", "examples"))
            << value.pointer();
    }
    for (const auto& [key, member] : value.members()) self(self, member);
    for (std::size_t i = 0; value.type() == JsonType::kArray && i < value.size(); ++i)
      self(self, value.at(i));
  };
  check(check, request_schema().document().root());
}

TEST(Schema, ItsOwnExamplesAreValid) {
  const Value examples = request_schema().document().root()["examples"];
  ASSERT_GE(examples.size(), 2u);
  for (std::size_t i = 0; i < examples.size(); ++i) EXPECT_NO_THROW(parse(json_text(examples.at(i))));
}

TEST(Schema, BrokenSchemaIsOurMistake) {
  try {
    Schema(R"({"type": 3})");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kInternal);
  }
}

}  // namespace
}  // namespace furnace::api
