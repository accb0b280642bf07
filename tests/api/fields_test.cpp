// Every property of the schema, one by one: it is read, its default is the one of RenderSpec, its range is
// enforced.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/api/request_fixture.hpp"

namespace furnace::api {
namespace {

const Leaf& leaf_of(const std::vector<Leaf>& leaves, const FieldRow& row) {
  return *std::find_if(leaves.begin(), leaves.end(), [&](const Leaf& leaf) { return leaf.path == row.path; });
}

// RenderSpec states some default angles rounded to a hundredth of a radian, the schema whole degrees.
double rounded(double angle_rad) {
  return std::round(angle_rad * 100) / 100;
}

ContentHash hash_with_rounded_angles(std::string_view json) {
  RenderSpec spec = parse(json);
  if (auto* orbit = std::get_if<OrbitCamera>(&spec.camera.view)) {
    orbit->azimuth_rad = rounded(orbit->azimuth_rad);
    orbit->elevation_rad = rounded(orbit->elevation_rad);
    orbit->fov_y_rad = rounded(orbit->fov_y_rad);
  } else if (auto* look_at = std::get_if<LookAtCamera>(&spec.camera.view)) {
    look_at->fov_y_rad = rounded(look_at->fov_y_rad);
  }
  return spec_hash(spec);
}

TEST(Fields, TableNamesEachPropertyOfTheSchemaOnce) {
  std::multiset<std::string> in_schema, in_table;
  for (const Leaf& leaf : schema_leaves()) in_schema.insert(leaf.path);
  for (const FieldRow& row : field_rows()) in_table.emplace(row.path);
  EXPECT_EQ(in_schema, in_table);
}

TEST(Fields, EachChangesThePicture) {
  for (const FieldRow& row : field_rows()) {
    SCOPED_TRACE(row.path);
    EXPECT_NE(hash_of(with_value(row, row.one)), hash_of(with_value(row, row.other)));
    EXPECT_EQ(hash_of(with_value(row, row.one)), hash_of(with_value(row, row.one)));
  }
}

TEST(Fields, DefaultInTheSchemaIsWhatAbsenceMeans) {
  const std::vector<Leaf> leaves = schema_leaves();
  int defaults = 0;
  for (const FieldRow& row : field_rows()) {
    const Value value = leaf_of(leaves, row).declared["default"];
    if (!value) continue;
    SCOPED_TRACE(row.path);
    ++defaults;
    EXPECT_EQ(hash_with_rounded_angles(with_value(row, json_text(value))),
              hash_with_rounded_angles(without_field(row)));
  }
  EXPECT_GE(defaults, 20);
  const Value scene = request_schema().document().root()["properties"]["scene"]["default"];
  EXPECT_EQ(hash_of(R"({"scene":)" + json_text(scene) + "}"), hash_of("{}"));
}

// Lists and objects are no fields, so their defaults are compared here.
TEST(Fields, DefaultsOfListsAreWhatAbsenceMeans) {
  const Value definitions = request_schema().document().root()["$defs"];
  const auto map_hash = [](const std::string& members) {
    return hash_of(R"({"environment":{"map":{)" + members + "}}}");
  };
  const std::string gradient = R"("type":"gradient")", studio = R"("type":"studio")";
  const std::string stops = json_text(definitions["gradientEnvironment"]["properties"]["stops"]["default"]);
  EXPECT_EQ(map_hash(gradient), map_hash(gradient + R"(,"stops":)" + stops));
  for (const char* key : {"lights", "room"}) {
    const Value value = definitions["studioEnvironment"]["properties"][key]["default"];
    EXPECT_EQ(map_hash(studio), map_hash(studio + ",\"" + key + "\":" + json_text(value))) << key;
  }
}

TEST(Fields, KindsOfEnvironmentsDiffer) {
  std::set<std::string> hashes;
  const std::vector<std::string> maps = {R"({"color":[1,1,1]})", R"({"type":"gradient"})",
                                         R"({"type":"overcast"})", R"({"type":"clear-sky"})",
                                         R"({"type":"studio"})"};
  for (const std::string& map : maps) hashes.insert(hash_of(R"({"environment":{"map":)" + map + "}}").hex());
  EXPECT_EQ(hashes.size(), maps.size());
  EXPECT_EQ(hash_of(R"({"environment":{"map":{"color":[1,2,3]}}})"),
            hash_of(R"({"environment":{"map":{"type":"color","color":[1,2,3]}}})"));
}

// What the schema's author could forget: a leaf that neither has a default nor needs none.
TEST(Fields, OnlyOptionalThingsHaveNoDefault) {
  for (const Leaf& leaf : schema_leaves()) {
    const bool stated = static_cast<bool>(leaf.declared["default"]);
    const bool needs_none =
        leaf.path.starts_with("/scene/materials") || leaf.path == "/scene/model" ||
        leaf.path == "/scene/gltfScene" || leaf.path == "/scene/variant" ||
        leaf.path == "/scene/animation/name" || leaf.path == "/scene/animations/name" ||
        leaf.path == "/scene/files" || leaf.path == "/scene/upAxis" || leaf.path == "/texture/map" ||
        leaf.path == "/scene/nodes/mesh" || leaf.path == "/scene/nodes/name" ||
        leaf.path == "/scene/nodes/material" || leaf.path == "/map:color/color" ||
        leaf.path.ends_with("/stops/color") || leaf.path.ends_with("/stops/elevationDegrees") ||
        leaf.path == "/map:clear-sky/dateTime" || leaf.path == "/map:clear-sky/latitudeDegrees" ||
        leaf.path == "/map:clear-sky/longitudeDegrees" || leaf.path.starts_with("/camera/intrinsics/f") ||
        leaf.path.starts_with("/camera/intrinsics/c") || leaf.path == "/camera/intrinsics/width" ||
        leaf.path == "/camera/intrinsics/height" || leaf.path == "/camera/lookAt/eye" ||
        leaf.path == "/camera/lookAt/heightMetres" || leaf.path == "/output/sequence/frames" ||
        leaf.path == "/scene/lights/type" || leaf.path == "/scene/lights/fluxLumen" ||
        leaf.path == "/scene/lights/profile" || leaf.path == "/scene/lights/rangeMetres" ||
        leaf.path == "/environment/background/map" ||
        leaf.path == "/environment/background/rotationDegrees" ||
        leaf.path == "/environment/illuminanceLux" || leaf.path == "/environment/ground/levelMetres" ||
        leaf.path == "/environment/ground/projection/radiusMetres" || leaf.path == "/camera/gltf" ||
        leaf.path == "/camera/ev100" || leaf.path == "/camera/aperture" ||
        leaf.path == "/camera/shutterSeconds" || leaf.path == "/output/samples" ||
        leaf.path == "/output/exrCompression" || leaf.path == "/output/pixelFilter/type" ||
        leaf.path == "/output/pixelFilter/radiusPixels" ||
        leaf.path == "/camera/depthOfField/apertureDiameterMetres" ||
        leaf.path == "/camera/depthOfField/focusDistanceMetres" ||
        leaf.path == "/camera/depthOfField/focusPoint" || leaf.path == "/camera/motionBlur/shutterSeconds";
    EXPECT_NE(stated, needs_none) << leaf.path;
  }
}

TEST(Fields, RangesAreEnforcedAtTheirEnds) {
  const std::vector<Leaf> leaves = schema_leaves();
  int ranges = 0;
  for (const FieldRow& row : field_rows()) {
    const Value schema = leaf_of(leaves, row).resolved;
    if (!schema["minimum"]) continue;
    SCOPED_TRACE(row.path);
    ++ranges;
    ASSERT_TRUE(schema["maximum"]) << "a number without an upper end may overflow";
    const double low = schema["minimum"].number(), high = schema["maximum"].number();
    EXPECT_NO_THROW(parse(with_value(row, json_text(schema["minimum"])), generous_limits()));
    EXPECT_NO_THROW(parse(with_value(row, json_text(schema["maximum"])), generous_limits()));
    for (const double outside : {low - 1, high + 1}) {
      const Error error = refusal(with_value(row, std::to_string(outside)), generous_limits());
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
      const std::string key(row.path.substr(row.path.rfind('/')));
      EXPECT_TRUE(error.pointer.ends_with(key)) << error.pointer;
      EXPECT_NE(error.message.find("must be between"), std::string::npos) << error.message;
    }
  }
  EXPECT_GE(ranges, 15);
}

TEST(Fields, WrongTypesAreRefusedAtTheField) {
  for (const FieldRow& row : field_rows()) {
    SCOPED_TRACE(row.path);
    for (const std::string_view wrong : {"null", "[[]]", R"({"x":1})"}) {
      if (wrong == "null" && row.path.starts_with("/scene/materials/textures/")) continue;  // no texture
      const Error error = refusal(with_value(row, wrong));
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
      const std::string key(row.path.substr(row.path.rfind('/')));
      EXPECT_TRUE(error.pointer.find(key) != std::string::npos) << error.pointer;
      EXPECT_EQ(error.message.find("does not fit the schema"), std::string::npos);
    }
  }
}

TEST(Fields, EveryPropertyHasATitle) {
  for (const Leaf& leaf : schema_leaves()) {
    const bool titled = leaf.declared["title"] || leaf.resolved["title"];
    EXPECT_TRUE(titled) << leaf.path;
  }
}

TEST(Fields, ExamplesOfEachFieldAreAccepted) {
  const std::vector<Leaf> leaves = schema_leaves();
  for (const FieldRow& row : field_rows()) {
    const Value examples = leaf_of(leaves, row).declared["examples"];
    for (std::size_t i = 0; i < examples.size(); ++i) {
      const Document document = Document::parse(with_value(row, json_text(examples.at(i))), {});
      for (const Problem& problem : request_schema().problems(document))
        ADD_FAILURE() << row.path << ": " << problem.pointer << " " << problem.message;
    }
  }
}

}  // namespace
}  // namespace furnace::api
