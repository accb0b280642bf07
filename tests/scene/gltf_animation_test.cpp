// Animations by closed forms, visibility, instances.
#include <cmath>

#include <gmock/gmock.h>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

// A triangle whose property moves through `values` at `times`.
struct Moved {
  GltfBuilder builder = clean_builder();
  Json target = {{"node", 0}, {"path", "translation"}};
  std::string interpolation = "LINEAR", type = "VEC3";
  std::vector<float> times = {1, 3}, values = {0, 0, 0, 2, 4, 8};

  Moved& pointer(const std::string& pointer) {
    target = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
    return *this;
  }
  GltfBuilder built() const {
    GltfBuilder result = builder;
    const int input = result.add_accessor<float>("SCALAR", times);
    const int output = result.add_accessor<float>(type, values);
    result.add("animations",
               {{"name", "move"},
                {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
                {"channels", {{{"sampler", 0}, {"target", target}}}}});
    return result;
  }
  Scene at(double seconds, bool loop = false) const {
    ImportOptions options;
    options.animations = {{"move", {seconds, loop}}};
    return built().import(options);
  }
  glm::vec3 place(double seconds, bool loop = false) const {
    return glm::vec3(at(seconds, loop).instances.at(0).world_from_model[3]);
  }
  std::string refused_at() const {
    const auto error = error_of([&] { at(1); });
    return error ? error->pointer : "no error";
  }
};

TEST(GltfAnimation, LinearStandsStillOutsideItsKeyframes) {
  const Moved moved;
  EXPECT_EQ(moved.place(-5), glm::vec3(0));
  EXPECT_EQ(moved.place(1), glm::vec3(0));
  EXPECT_EQ(moved.place(1.5), glm::vec3(0.5f, 1, 2));
  EXPECT_EQ(moved.place(3), glm::vec3(2, 4, 8));
  EXPECT_EQ(moved.place(9), glm::vec3(2, 4, 8));
}

TEST(GltfAnimation, ListsItsNameAndLengthAndLeavesTheModelAtRest) {
  const Scene scene = Moved().built().import();
  ASSERT_THAT(scene.animations, SizeIs(1));
  EXPECT_EQ(scene.animations[0].name, "move");
  EXPECT_EQ(scene.animations[0].duration_s, 3);
  EXPECT_EQ(scene.instances.at(0).world_from_model, glm::mat4(1));
}

TEST(GltfAnimation, LoopsModuloItsLength) {
  const Moved moved;
  EXPECT_EQ(moved.place(3 + 1.5, true), moved.place(1.5));
  EXPECT_EQ(moved.place(-1, true), moved.place(2));
}

TEST(GltfAnimation, StepHoldsEachKeyframe) {
  Moved moved;
  moved.interpolation = "STEP";
  EXPECT_EQ(moved.place(2.999), glm::vec3(0));
  EXPECT_EQ(moved.place(3), glm::vec3(2, 4, 8));
}

// A spline through the values and tangents of a cubic is that cubic.
TEST(GltfAnimation, SplineIsTheCubicItsTangentsDescribe) {
  const auto cubic = [](float t) { return t * t * t - 2 * t + 1; };
  const auto slope = [](float t) { return 3 * t * t - 2; };
  Moved moved;
  moved.interpolation = "CUBICSPLINE";
  moved.times = {0.5f, 2};
  moved.values.clear();
  for (const float t : moved.times)
    moved.values.insert(moved.values.end(), {slope(t), 0, 0, cubic(t), 0, 0, slope(t), 0, 0});
  for (const float t : {0.5f, 0.7f, 1.1f, 1.9f, 2.0f}) EXPECT_NEAR(moved.place(t).x, cubic(t), 1e-5) << t;
}

TEST(GltfAnimation, RotationsTakeTheShorterWayAtConstantSpeed) {
  Moved moved;
  moved.target["path"] = "rotation";
  moved.type = "VEC4";
  const float half = std::sqrt(0.5f);
  moved.values = {0, 0, 0, 1, 0, -half, 0, -half};  // the second is a quarter turn about y, negated
  const glm::mat4 world = moved.at(1 + 2.0 / 3).instances.at(0).world_from_model;
  const double angle = std::numbers::pi / 6;
  EXPECT_NEAR(world[2].x, std::sin(angle), 1e-6);
  EXPECT_NEAR(world[2].z, std::cos(angle), 1e-6);
}

TEST(GltfAnimation, WeightsMoveMorphTargets) {
  Moved moved;
  const int up = moved.builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int right = moved.builder.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0});
  primitive_of(moved.builder)["targets"] = {{{"POSITION", up}}, {{"POSITION", right}}};
  moved.target["path"] = "weights";
  moved.type = "SCALAR";
  moved.values = {0, 0, 1, 0.5f};
  EXPECT_EQ(moved.at(2).meshes.at(0)->positions[0], glm::vec3(0.25f, 0, 0.5f));
  EXPECT_EQ(Moved(moved).pointer("/meshes/0/weights").at(2).meshes.at(0)->positions[0],
            glm::vec3(0.25f, 0, 0.5f));
  moved.values = {0, 2};
  EXPECT_EQ(Moved(moved).pointer("/nodes/0/weights/1").refused_at(), "no error");
  moved.builder.json["meshes"][0]["weights"] = {0.5, 0};
  EXPECT_EQ(Moved(moved).pointer("/nodes/0/weights/1").at(2).meshes.at(0)->positions[0],
            glm::vec3(1, 0, 0.5f));
}

TEST(GltfAnimation, PointersMoveMaterialsLightsAndCameras) {
  Moved moved;
  moved.builder.add("materials", Json::object());
  primitive_of(moved.builder)["material"] = 0;
  moved.type = "SCALAR";
  moved.values = {0, 1};
  moved.pointer("/materials/0/pbrMetallicRoughness/roughnessFactor");
  EXPECT_FLOAT_EQ(moved.at(1.5).materials.at(0).perceptual_roughness, 0.25f);

  moved.builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  moved.builder.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  moved.pointer("/extensions/KHR_lights_punctual/lights/0/intensity");
  EXPECT_FLOAT_EQ(float(moved.at(2).lights.at(0).intensity.x), 0.5f);

  moved.builder.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
  moved.builder.json["nodes"][0]["camera"] = 0;
  moved.pointer("/cameras/0/perspective/yfov");
  EXPECT_NEAR(moved.at(2).cameras.at(0).fov_y_rad, 0.5, 1e-6);
}

TEST(GltfAnimation, WhatItCannotMoveBecomesANote) {
  for (const char* pointer :
       {"/materials/7/alphaCutoff", "/nodes/0/name", "/nodes/00/translation", "/nodes/0/translation/0",
        "nodes", "", "/materials/0/extensions/KHR_materials_volume/thicknessFactor",
        "/nodes/0/translation/"}) {
    Moved moved;
    moved.builder.add("materials", Json::object());
    const Scene scene = moved.pointer(pointer).at(2);
    ASSERT_THAT(scene.notes, SizeIs(1)) << pointer;
    EXPECT_EQ(scene.notes[0].code, "animation-channel-ignored");
    EXPECT_EQ(scene.notes[0].pointer, "/animations/0/channels/0/target");
  }
  Moved placed;
  placed.builder.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
  EXPECT_EQ(placed.place(2), glm::vec3(5, 6, 7));
}

TEST(GltfAnimation, WeightsMustBeThoseOfTheMesh) {
  Moved moved;
  moved.target["path"] = "weights";
  moved.type = "SCALAR";
  moved.values = {0, 1};
  const Scene scene = moved.at(2);
  ASSERT_THAT(scene.notes, SizeIs(1));
  EXPECT_EQ(scene.notes[0].code, "animation-channel-ignored");
  primitive_of(moved.builder)["targets"] = {
      {{"POSITION", moved.builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1})}}};
  EXPECT_EQ(moved.refused_at(), "no error");
  moved.values = {0, 1, 0, 1};
  EXPECT_EQ(moved.refused_at(), "/animations/0/samplers/0/output");
}

TEST(GltfAnimation, LaterClipsHaveTheLastWord) {
  GltfBuilder builder = Moved().built();
  Json other = builder.json["animations"][0];
  other["name"] = "other";
  builder.add("animations", other);
  ImportOptions options;
  options.animations = {{"move", {3, false}}, {1, {2, false}}};
  EXPECT_EQ(builder.import(options).instances.at(0).world_from_model[3].x, 1);
}

TEST(GltfAnimation, DamagedKeyframesAreRefusedWherePlayedAndNotedWhereNot) {
  Moved moved;
  moved.times = {1, 1};
  EXPECT_EQ(moved.refused_at(), "/animations/0/samplers/0/input");
  EXPECT_EQ(moved.built().import().notes.at(0).code, "animation-damaged");
  moved.times = {1, 2};
  moved.values[1] = std::nanf("");
  EXPECT_EQ(moved.refused_at(), "/animations/0/samplers/0/output");
  moved.values = {0, 0, 0};
  EXPECT_EQ(moved.refused_at(), "/animations/0/samplers/0/output");
  moved.type = "SCALAR";
  EXPECT_EQ(moved.refused_at(), "/animations/0/samplers/0/output");
  moved.interpolation = "SMOOTH";
  EXPECT_EQ(moved.refused_at(), "/animations/0/samplers/0/interpolation");
}

TEST(GltfAnimation, MeshesThatDoNotMoveKeepTheirKeys) {
  const Moved moved;
  EXPECT_EQ(moved.at(1).meshes.at(0)->key, moved.at(2).meshes.at(0)->key);
  EXPECT_NE(moved.at(1).hash, moved.at(2).hash);
}

// A model that is parsed once gives at every time, in any order, what an import of its own gives.
TEST(GltfModel, AtSeveralTimesIsEachAlone) {
  Moved moved;
  const int up = moved.builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  Json still = moved.builder.json["meshes"][0];
  primitive_of(moved.builder)["targets"] = {{{"POSITION", up}}};
  moved.builder.add("meshes", still);
  moved.builder.add("nodes", {{"mesh", 1}});
  moved.builder.add("scenes", {{"nodes", {0, 1}}});
  moved.target["path"] = "weights";
  moved.type = "SCALAR";
  moved.values = {0, 1};
  const ModelBundle bundle = moved.built().bundle();
  const ImportLimits limits;
  const Deadline deadline;
  GltfModel model(decode::in_process_decoder(), bundle, limits, deadline, GltfModel::Times::kSeveral);
  SharedMesh at_rest;
  for (const double seconds : {2.0, 1.0, 2.5, 2.0}) {
    ImportOptions options;
    options.animations = {{"move", {seconds, false}}};
    const Scene scene = model.import(options), alone = moved.at(seconds);
    EXPECT_EQ(scene.hash, alone.hash);
    ASSERT_EQ(scene.meshes.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(scene.meshes[i]->key, alone.meshes[i]->key);
      EXPECT_EQ(scene.meshes[i]->positions, alone.meshes[i]->positions);
      EXPECT_EQ(scene.instances[i].place, alone.instances[i].place);
    }
    EXPECT_NE(scene.instances[0].place, scene.instances[1].place);
    if (at_rest != nullptr) {
      EXPECT_EQ(scene.meshes[1], at_rest);
    }
    at_rest = scene.meshes[1];
  }
}

TEST(GltfVisibility, AHiddenNodeHidesWhatIsBelow) {
  GltfBuilder builder = clean_builder({{"children", {1}}});
  builder.add("nodes", {{"mesh", 0}, {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}});
  EXPECT_THAT(builder.import().instances, SizeIs(2));
  builder.json["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = false;
  EXPECT_THAT(builder.import().instances, SizeIs(1));
  builder.json["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = true;
  builder.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = false;
  EXPECT_THAT(builder.import().instances, IsEmpty());
}

// Samplers may share accessors: each reading counts.
TEST(GltfAnimation, KeyframesAreLimited) {
  GltfBuilder builder = Moved().built();
  Json& samplers = builder.json["animations"][0]["samplers"];
  for (int i = 0; i < 9; ++i) samplers.push_back(samplers[0]);
  ImportLimits limits;
  limits.max_keyframe_numbers = 20;
  EXPECT_EQ(pointer_of_error(builder, limits), "no error");
  limits.max_keyframe_numbers = 19;
  EXPECT_EQ(pointer_of_error(builder, limits), "/animations/0/samplers/9/input");
}

TEST(GltfVisibility, AnimationsShowAndHide) {
  Moved moved;
  moved.builder.json["nodes"][0]["extensions"]["KHR_node_visibility"] = Json::object();
  moved.type = "SCALAR";
  moved.values = {1, 0};
  moved.pointer("/nodes/0/extensions/KHR_node_visibility/visible");
  EXPECT_THAT(moved.at(2.9).instances, SizeIs(1));
  EXPECT_THAT(moved.at(3).instances, IsEmpty());
}

GltfBuilder instanced_builder() {
  GltfBuilder builder = clean_builder({{"translation", {0, 0, 10}}});
  const int places = builder.add_accessor<float>("VEC3", {1, 0, 0, 0, 2, 0});
  const int scales = builder.add_accessor<float>("VEC3", {1, 1, 1, 3, 3, 3});
  const int turns = builder.add_accessor<std::int16_t>("VEC4", {0, 0, 0, 32767, 0, 0, 32767, 0}, true);
  builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", scales}};
  return builder;
}

TEST(GltfInstances, StandAtTheirPlacesInTheNode) {
  const Scene scene = instanced_builder().import();
  ASSERT_THAT(scene.instances, SizeIs(2));
  EXPECT_THAT(scene.meshes, SizeIs(1));
  EXPECT_EQ(scene.instances[0].world_from_model[3], glm::vec4(1, 0, 10, 1));
  EXPECT_EQ(scene.instances[1].world_from_model[3], glm::vec4(0, 2, 10, 1));
  EXPECT_NEAR(scene.instances[1].world_from_model[0].x, -3,
              1e-6);  // half a turn about z, three times as large
}

TEST(GltfInstances, OfAllNodesAreCountedTogether) {
  GltfBuilder builder = instanced_builder();
  builder.json["nodes"].push_back(builder.json["nodes"][0]);
  builder.json["scenes"][0]["nodes"] = {0, 1};
  ImportLimits limits;
  limits.max_instances = 4;
  EXPECT_EQ(pointer_of_error(builder, limits), "no error");
  limits.max_instances = 3;
  EXPECT_EQ(pointer_of_error(builder, limits), "/nodes/1/extensions/EXT_mesh_gpu_instancing/attributes");
}

TEST(GltfInstances, AreCheckedBeforeUse) {
  GltfBuilder builder = instanced_builder();
  Json& attributes = builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  const std::string place = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
  ImportLimits one;
  one.max_instances = 1;
  EXPECT_EQ(pointer_of_error(builder, one), place);
  attributes["SCALE"] = builder.add_accessor<float>("VEC3", {1, 1, 1});
  EXPECT_EQ(pointer_of_error(builder), place + "/SCALE");
  attributes["SCALE"] = builder.add_accessor<float>("VEC4", {1, 1, 1, 1, 1, 1, 1, 1});
  EXPECT_EQ(pointer_of_error(builder), place + "/SCALE");
}

}  // namespace
}  // namespace furnace::testing
