#include "api/render_request.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "api/problem.hpp"
#include "renderer/scene/procedural.hpp"
#include "tests/api/request_fixture.hpp"

namespace furnace::api {
namespace {

using testing::HasSubstr;

TEST(RenderRequest, EmptyDocumentIsRenderSpecWithTheDefaultScene) {
  RenderSpec expected;
  NodeSpec node;
  node.mesh = kDefaultMesh;
  node.material = kDefaultPreset;
  expected.scene.nodes = {node};
  expected.output.samples = samples_for_quality(kDefaultQuality);
  EXPECT_EQ(spec_hash(parse("{}")), spec_hash(expected));
}

TEST(RenderRequest, DefaultsExist) {
  const auto meshes = builtin_mesh_names();
  const auto environments = builtin_environment_names();
  EXPECT_THAT(meshes, testing::Contains(kDefaultMesh));
  EXPECT_TRUE(material_preset(kDefaultPreset));
  EXPECT_THAT(environments, testing::Contains(std::get<BuiltinName>(parse("{}").environment.map).name));
}

TEST(RenderRequest, DegreesBecomeRadians) {
  const RenderSpec spec = parse(R"({"environment":{"rotationDegrees":-90},
      "camera":{"orbit":{"azimuthDegrees":180,"elevationDegrees":-45},"fovYDegrees":60}})");
  const auto& orbit = std::get<OrbitCamera>(spec.camera.view);
  EXPECT_DOUBLE_EQ(spec.environment.rotation_rad, -std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(orbit.azimuth_rad, std::numbers::pi);
  EXPECT_DOUBLE_EQ(orbit.elevation_rad, -std::numbers::pi / 4);
  EXPECT_DOUBLE_EQ(orbit.fov_y_rad, std::numbers::pi / 3);
}

TEST(RenderRequest, NodesCarryTheirPlacement) {
  const RenderSpec spec = parse(R"({"scene":{"nodes":[
      {"mesh":"builtin:torus","material":"mine","translation":[1,2,3],"rotation":[0,0,1,1],"scale":[2,2,0.5]}],
      "materials":{"mine":{"preset":"chrome","baseColor":[0.1,0.2,0.3],"alphaMode":"BLEND"},"other":"gold"}}})");
  ASSERT_EQ(spec.scene.nodes.size(), 1u);
  const NodeSpec& node = spec.scene.nodes[0];
  EXPECT_EQ(node.mesh, "torus");
  EXPECT_EQ(node.material, "mine");
  EXPECT_EQ(node.translation, glm::vec3(1, 2, 3));
  EXPECT_EQ(node.scale, glm::vec3(2, 2, 0.5));
  const float half_turn = std::numbers::sqrt2_v<float> / 2;  // x y z w in the request, brought to length 1
  EXPECT_FLOAT_EQ(node.rotation.z, half_turn);
  EXPECT_FLOAT_EQ(node.rotation.w, half_turn);
  EXPECT_EQ(node.rotation.x, 0);
  const MaterialOverride& mine = spec.scene.materials.at("mine");
  EXPECT_EQ(mine.preset, "chrome");
  EXPECT_EQ(mine.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 1));
  EXPECT_EQ(mine.alpha_mode, AlphaMode::kBlend);
  EXPECT_FALSE(mine.metallic);
  EXPECT_EQ(spec.scene.materials.at("other").preset, "gold");
}

TEST(RenderRequest, ModelIsAFileOrShortForANode) {
  const RenderSpec file = parse(R"({"scene":{"model":"part:model.gltf","gltfScene":2}})");
  ASSERT_TRUE(file.scene.model);
  EXPECT_EQ(file.scene.gltf_scene, 2);
  EXPECT_TRUE(file.scene.nodes.empty());
  const RenderSpec both =
      parse(R"({"scene":{"model":"part:model.gltf","nodes":[{"mesh":"builtin:plane"}]}})");
  EXPECT_TRUE(both.scene.model);
  EXPECT_EQ(both.scene.nodes.size(), 1u);
  EXPECT_FALSE(both.scene.nodes[0].material) << "glTF's default material";
  const RenderSpec builtin = parse(R"({"scene":{"model":"builtin:cube"}})");
  EXPECT_FALSE(builtin.scene.model);
  ASSERT_EQ(builtin.scene.nodes.size(), 1u);
  EXPECT_EQ(builtin.scene.nodes[0].mesh, "cube");
  EXPECT_EQ(builtin.scene.nodes[0].material, kDefaultPreset);
  EXPECT_TRUE(parse(R"({"scene":{"nodes":[]}})").scene.nodes.empty()) << "the background alone";
}

TEST(RenderRequest, EnvironmentIsBuiltInFileOrColor) {
  EXPECT_EQ(
      std::get<BuiltinName>(parse(R"({"environment":{"map":"builtin:overcast"}})").environment.map).name,
      "overcast");
  EXPECT_EQ(std::get<EnvironmentFile>(parse(R"({"environment":{"map":"part:sky.hdr"}})").environment.map)
                .bytes.text(),
            "#?RADIANCE\n");
  EXPECT_EQ(std::get<EnvironmentColor>(parse(R"({"environment":{"map":{"color":[1,2,3]}}})").environment.map)
                .radiance,
            glm::vec3(1, 2, 3));
}

template <class T>
T procedural(const std::string& members) {
  const RenderSpec spec = parse(R"({"environment":{"map":{)" + members + "}}}");
  return std::get<T>(std::get<ProceduralEnvironment>(spec.environment.map));
}

TEST(RenderRequest, EnvironmentIsDescribedByItsKind) {
  const auto gradient = procedural<GradientEnvironment>(
      R"("type":"gradient","stops":[{"elevationDegrees":-10,"color":[1,2,3]},{"elevationDegrees":5,"color":[4,5,6]}])");
  ASSERT_EQ(gradient.stops.size(), 2u);
  EXPECT_EQ(gradient.stops[1].elevation_deg, 5);
  EXPECT_EQ(gradient.stops[1].radiance, glm::dvec3(4, 5, 6));
  EXPECT_EQ(procedural<OvercastEnvironment>(R"("type":"overcast","zenithLuminance":7)").zenith_luminance, 7);
  const auto studio = procedural<StudioEnvironment>(
      R"("type":"studio","lights":[{},{"shape":"disc","rollDegrees":90,"widthDegrees":60,"luminance":2}])");
  ASSERT_EQ(studio.lights.size(), 2u);
  EXPECT_EQ(studio.lights[1].shape, LightShape::kDisc);
  EXPECT_DOUBLE_EQ(studio.lights[1].roll_rad, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(studio.lights[1].width_rad, std::numbers::pi / 3);
  EXPECT_EQ(studio.lights[1].luminance, 2);
}

// At the equinox on the equator; the equation of time is 7.5 minutes, 2 degrees.
TEST(RenderRequest, SunOfADateStandsInItsQuarterOfTheWorld) {
  const auto sun = [](const std::string& time, const std::string& more = "") {
    const auto sky = procedural<ClearSkyEnvironment>(
        R"("type":"clear-sky","latitudeDegrees":40,"longitudeDegrees":0,"dateTime":"2026-03-20T)" + time +
        "\"" + more);
    return glm::dvec3(std::sin(sky.sun_azimuth_rad) * std::cos(sky.sun_elevation_rad),
                      std::sin(sky.sun_elevation_rad),
                      std::cos(sky.sun_azimuth_rad) * std::cos(sky.sun_elevation_rad));
  };
  EXPECT_GT(sun("06:15:00Z").x, 0.99) << "east is +X";
  EXPECT_LT(sun("18:00:00Z").x, -0.99) << "west is -X";
  EXPECT_NEAR(sun("12:07:30Z").z, std::sin(40 * std::numbers::pi / 180), 0.01) << "south is +Z";
  EXPECT_NEAR(sun("12:07:30Z").y, std::cos(40 * std::numbers::pi / 180), 0.01);
  EXPECT_GT(sun("06:15:00Z", R"(,"northDegrees":90)").z, 0.99) << "with north at +X, east is +Z";
}

TEST(RenderRequest, CamerasAreOneOfThree) {
  const auto look_at = std::get<LookAtCamera>(
      parse(R"({"camera":{"lookAt":{"eye":[1,2,3],"target":[0,1,0]},"fovYDegrees":90}})").camera.view);
  EXPECT_EQ(look_at.eye, glm::vec3(1, 2, 3));
  EXPECT_EQ(look_at.target, glm::vec3(0, 1, 0));
  EXPECT_EQ(look_at.up, glm::vec3(0, 1, 0));
  EXPECT_DOUBLE_EQ(look_at.fov_y_rad, std::numbers::pi / 2);
  EXPECT_EQ(std::get<int>(std::get<GltfCamera>(parse(R"({"camera":{"gltf":3}})").camera.view).which), 3);
  EXPECT_EQ(
      std::get<std::string>(std::get<GltfCamera>(parse(R"({"camera":{"gltf":"top"}})").camera.view).which),
      "top");
}

TEST(RenderRequest, HighQualityIsWhereVisibilityBegins) {
  EXPECT_EQ(samples_for_quality("high"), kVisibilitySamples);
}

TEST(RenderRequest, QualityIsANumberOfSamplesByName) {
  for (const QualityLevel& level : kQualityLevels) {
    const std::string name(level.name);
    EXPECT_EQ(parse(R"({"output":{"quality":")" + name + "\"}}").output.samples, level.samples);
    const Value description =
        request_schema().document().root()["properties"]["output"]["properties"]["quality"]["description"];
    EXPECT_THAT(std::string(description.text()), HasSubstr(name + " " + std::to_string(level.samples)));
  }
  EXPECT_EQ(parse(R"({"output":{"samples":7}})").output.samples, 7);
}

TEST(RenderRequest, FormatNotStatedIsTheCallersChoice) {
  FileAssets files({}, 0, 0);
  const AssetResolver assets(files, {}, {});
  EXPECT_EQ(parse_render_request("{}", assets, {}, OutputFormat::kExr).output.format, OutputFormat::kExr);
  EXPECT_EQ(
      parse_render_request(R"({"output":{"format":"png"}})", assets, {}, OutputFormat::kExr).output.format,
      OutputFormat::kPng);
}

TEST(RenderRequest, LimitsAreTooLargeAndSaySo) {
  const Error side = refusal(R"({"output":{"width":5000,"height":16384}})");
  EXPECT_EQ(side.code, ErrorCode::kTooLarge);
  ASSERT_EQ(side.problems.size(), 2u);
  EXPECT_EQ(side.problems[0].pointer, "/output/width");
  EXPECT_THAT(side.problems[0].message, HasSubstr("5000 px are more than this server's 4096 px a side"));
  EXPECT_EQ(side.problems[1].pointer, "/output/height");

  RequestLimits small;
  small.max_area_px = 1000;
  small.max_samples = 3;
  const Error area = refusal(R"({"output":{"quality":"reference"}})", small);
  EXPECT_EQ(area.code, ErrorCode::kTooLarge);
  ASSERT_EQ(area.problems.size(), 2u);
  EXPECT_EQ(area.problems[0].pointer, "/output");
  EXPECT_EQ(area.problems[1].pointer, "/output/quality");
  EXPECT_EQ(refusal(R"({"output":{"width":10,"height":10,"samples":4}})", small).pointer, "/output/samples");
  EXPECT_NO_THROW(parse(R"({"output":{"width":10,"height":100,"samples":3}})", small));
  small = {};
  small.max_samples = 0;
  EXPECT_EQ(refusal("{}", small).pointer, "/output/quality") << "the default is told by its name";

  RequestLimits short_text;
  short_text.max_json_bytes = 10;
  EXPECT_EQ(refusal(R"({"strict":false})", short_text).code, ErrorCode::kTooLarge);
}

TEST(RenderRequest, MissingFilesAreToldTogether) {
  const Error error = refusal(R"({"scene":{"model":"part:none.glb"},"environment":{"map":"part:none.hdr"}})");
  EXPECT_EQ(error.code, ErrorCode::kNotFound);
  ASSERT_EQ(error.problems.size(), 2u);
  EXPECT_EQ(error.problems[0].pointer, "/scene/model");
  EXPECT_EQ(error.problems[1].pointer, "/environment/map");
}

TEST(RenderRequest, FaultsOfSeveralKindsAreUnprocessable) {
  const Error error =
      refusal(R"({"scene":{"model":"part:none.glb","nodes":[{"mesh":"builtin:cube","material":"glod"}]},
      "output":{"width":8000}})");
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  ASSERT_EQ(error.problems.size(), 3u);
  EXPECT_EQ(error.problems[1].pointer, "/scene/nodes/0/material");
  EXPECT_THAT(error.problems[1].message, HasSubstr("did you mean \"gold\"?"));
}

TEST(RenderRequest, StopsCountingAtAHundred) {
  std::string nodes = R"({"scene":{"nodes":[{"mesh":"builtin:cube","material":"x"})";
  for (int i = 0; i < 500; ++i) nodes += R"(,{"mesh":"builtin:cube","material":"x"})";
  EXPECT_EQ(refusal(nodes + "]}}").problems.size(), kMaxProblems);
}

TEST(RenderRequest, NamesThatDoNotExistAreRefused) {
  EXPECT_THAT(refusal(R"({"environment":{"map":"builtin:studoi"}})").message,
              HasSubstr(R"(there is no built-in environment "studoi"; did you mean "studio"?)"));
  EXPECT_EQ(refusal(R"({"scene":{"model":"builtin:teapot"}})").pointer, "/scene/model");
  EXPECT_EQ(refusal(R"({"scene":{"gltfScene":0}})").pointer, "/scene/gltfScene");
  EXPECT_EQ(refusal(R"({"scene":{"upAxis":"z"}})").pointer, "/scene/upAxis");
  EXPECT_EQ(refusal(R"({"scene":{"model":"part:model.gltf","upAxis":"z"}})").pointer, "/scene/upAxis");
  EXPECT_EQ(refusal(R"({"scene":{"model":"part:model.obj","gltfScene":0}})").pointer, "/scene/gltfScene");
  EXPECT_EQ(refusal(R"({"scene":{"model":"builtin:cube","gltfScene":0}})").pointer, "/scene/gltfScene");
  EXPECT_EQ(refusal(R"({"scene":{"nodes":[{"mesh":"builtin:cube","rotation":[0,0,0,0]}]}})").pointer,
            "/scene/nodes/0/rotation");
  EXPECT_EQ(refusal(R"({"scene":{"model":"https://example.com/a.glb"}})").pointer, "/scene/model");
}

TEST(RenderRequest, NamedFilesStandForWhatTheModelNames) {
  const auto chair = [](std::string_view files) {
    return fmt::format(R"({{"scene":{{"model":"part:chair.gltf","files":{}}}}})", files);
  };
  const RenderSpec spec = parse(chair(R"({"oak.png":"part:b.png"})"), generous_limits());
  EXPECT_EQ(spec.scene.model->siblings.at("oak.png").text().back(), 'b');
  EXPECT_NE(hash_of(chair(R"({"oak.png":"part:b.png"})")), hash_of(chair(R"({"oak.png":"part:a.png"})")));

  const Error missing = refusal(chair(R"({"oak.png":"part:none.png","a/b":"part:no"})"));
  ASSERT_EQ(missing.problems.size(), 2u) << "all at once";
  EXPECT_EQ(missing.problems[0].pointer, "/scene/files/a~1b");
  EXPECT_EQ(missing.problems[1].pointer, "/scene/files/oak.png");

  const Error unknown = refusal(chair(R"({"oak.jpg":"part:a.png"})"));
  EXPECT_EQ(unknown.pointer, "/scene/files/oak.jpg");
  EXPECT_THAT(unknown.message, HasSubstr("it names \"oak.png\""));
  EXPECT_EQ(refusal(R"({"scene":{"files":{"a":"part:a.png"}}})").pointer, "/scene/files");
  EXPECT_EQ(refusal(R"({"scene":{"model":"builtin:cube","files":{"a":"part:a.png"}}})").pointer,
            "/scene/files");
}

TEST(RenderRequest, SamePictureFromOtherJsonHasTheSameHash) {
  EXPECT_EQ(hash_of(R"({"output":{"width":64,"height":32}})"),
            hash_of("{ \"output\" : { \"height\" : 3.2e1, \"width\" : 64.0 } }"));
  EXPECT_EQ(hash_of(R"({"output":{"quality":"standard"}})"), hash_of("{}"));
}

// std::regex would overflow the stack on a string like this; nothing in the schema may use one.
TEST(RenderRequest, LongDataUrisAreRead) {
  const std::string uri = "data:application/octet-stream;base64," + std::string(3 << 20, 'A');
  const RenderSpec spec = parse(R"({"environment":{"map":")" + uri + "\"}}");
  EXPECT_GT(std::get<EnvironmentFile>(spec.environment.map).bytes.size(), 1u << 20);
}

}  // namespace
}  // namespace furnace::api
