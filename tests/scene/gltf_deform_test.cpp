#include <gmock/gmock.h>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<float> kTriangle{0, 0, 0, 1, 0, 0, 0, 1, 0};
const std::vector<float> kNormals{0, 0, 1, 0, 0, 1, 0, 0, 1};

// Two targets: the first lifts by z, the second moves along x and tilts normals towards +x.
GltfBuilder morph_builder() {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", kTriangle);
  const int normal = builder.add_accessor<float>("VEC3", kNormals);
  const int color = builder.add_accessor<float>("VEC3", {0.5f, 0, 0, 0.5f, 0, 0, 0.5f, 0, 0});
  const int lift = builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int along_x = builder.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0});
  const int redden = builder.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0});
  builder.show({{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"COLOR_0", color}}},
                {"targets",
                 {{{"POSITION", lift}}, {{"POSITION", along_x}, {"NORMAL", along_x}, {"COLOR_0", redden}}}}});
  return builder;
}

TEST(MorphTargets, RestAtZeroWithoutWeights) {
  const Scene scene = morph_builder().import();
  EXPECT_EQ(scene.meshes.at(0)->positions[0], glm::vec3(0));
  EXPECT_THAT(scene.notes, IsEmpty());
}

TEST(MorphTargets, AddWeightedDisplacements) {
  GltfBuilder builder = morph_builder();
  builder.json["meshes"][0]["weights"] = {0.5, 1};
  const Scene scene = builder.import();
  const Mesh& mesh = *scene.meshes.at(0);
  EXPECT_THAT(mesh.positions,
              ElementsAre(glm::vec3(1, 0, 0.5f), glm::vec3(2, 0, 0.5f), glm::vec3(1, 1, 0.5f)));
  EXPECT_LT(glm::distance(mesh.normals[0], glm::normalize(glm::vec3(1, 0, 1))), 1e-6f);
  EXPECT_EQ(mesh.colors[0], glm::vec4(1, 0, 0, 1));  // clamped
  EXPECT_EQ(mesh.bounds.min, glm::vec3(1, 0, 0.5f));
}

TEST(MorphTargets, ANodesWeightsComeBeforeItsMeshs) {
  GltfBuilder builder = morph_builder();
  builder.json["meshes"][0]["weights"] = {0.5, 0};
  builder.json["nodes"][0]["weights"] = {2, 0};
  builder.add("nodes", {{"mesh", 0}});
  const Scene scene = builder.import();
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0]->positions[0].z, 2);
  EXPECT_EQ(scene.meshes[1]->positions[0].z, 0.5f);
}

TEST(MorphTargets, FlatNormalsAreOfTheDisplacedTriangles) {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", kTriangle);
  // Turns the triangle into the plane x = 0: its normal becomes (-1, 0, 0).
  const int turn = builder.add_accessor<float>("VEC3", {0, 0, 0, -1, 0, 1, 0, 0, 0});
  builder.show({{"attributes", {{"POSITION", position}}}, {"targets", {{{"POSITION", turn}}}}});
  builder.json["meshes"][0]["weights"] = {1};
  EXPECT_EQ(builder.import().meshes.at(0)->normals[0], glm::vec3(-1, 0, 0));
}

TEST(MorphTargets, AreChecked) {
  GltfBuilder builder = morph_builder();
  builder.json["nodes"][0]["weights"] = {1};
  EXPECT_EQ(pointer_of_error(builder), "/nodes/0/weights");
  builder = morph_builder();
  builder.json["meshes"][0]["weights"] = {1, 2, 3};
  EXPECT_EQ(pointer_of_error(builder), "/meshes/0/weights");
  builder = morph_builder();
  builder.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"] =
      builder.add_accessor<float>("VEC3", {0, 0, 0});
  EXPECT_EQ(pointer_of_error(builder), "/meshes/0/primitives/0/targets/1/POSITION");
  builder = morph_builder();
  builder.json["meshes"][0]["weights"] = {1e300, 0};
  EXPECT_EQ(pointer_of_error(builder), "/meshes/0/primitives/0/targets/0/POSITION");
}

// A triangle whose vertices hang on two joints: vertex 0 on the first, 1 on the second, 2 on both alike.
// Nodes: 0 the mesh, 1 and 2 the joints.
struct SkinSpec {
  std::vector<std::uint8_t> joints{0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
  std::vector<float> weights{1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0};
  Json first_joint = Json::object(), second_joint = Json::object(), mesh_node = Json::object();
  std::vector<float> inverse_bind;  // none: identities
};

GltfBuilder skin_builder(const SkinSpec& spec) {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", kTriangle);
  const int normal = builder.add_accessor<float>("VEC3", kNormals);
  const int joints = builder.add_accessor<std::uint8_t>("VEC4", spec.joints);
  const int weights = builder.add_accessor<float>("VEC4", spec.weights);
  Json node = spec.mesh_node;
  node["skin"] = 0;
  builder.show({{"attributes",
                 {{"POSITION", position}, {"NORMAL", normal}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}}},
               node);
  builder.add("nodes", spec.first_joint);
  builder.add("nodes", spec.second_joint);
  Json skin = {{"joints", {1, 2}}};
  if (!spec.inverse_bind.empty()) {
    skin["inverseBindMatrices"] = builder.add_accessor<float>("MAT4", spec.inverse_bind);
  }
  builder.add("skins", skin);
  return builder;
}

TEST(Skin, PlacesVerticesByTheirJointsAlone) {
  SkinSpec spec;
  spec.mesh_node = {{"translation", {100, 0, 0}}};  // ignored, as glTF says
  spec.first_joint = {{"translation", {0, 0, 2}}};
  spec.second_joint = {{"translation", {0, 4, 0}}};
  const Scene scene = skin_builder(spec).import();
  EXPECT_THAT(scene.meshes.at(0)->positions,
              ElementsAre(glm::vec3(0, 0, 2), glm::vec3(1, 4, 0), glm::vec3(0, 3, 1)));
  EXPECT_EQ(scene.instances.at(0).world_from_model, glm::mat4(1));
  EXPECT_THAT(scene.notes, IsEmpty());
}

TEST(Skin, InverseBindMatricesComeFirst) {
  SkinSpec spec;
  const double half = std::sqrt(0.5);
  spec.second_joint = {{"translation", {1, 0, 0}}, {"rotation", {0, 0, half, half}}};
  // Bound at (1, 0, 0): the joint turns vertex 1 about itself.
  spec.inverse_bind = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                       1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1};
  const Scene scene = skin_builder(spec).import();
  EXPECT_LT(glm::distance(scene.meshes.at(0)->positions[1], glm::vec3(1, 0, 0)), 1e-6f);
}

TEST(Skin, NormalsFollowTheInverseTranspose) {
  SkinSpec spec;
  const double half = std::sqrt(0.5);
  // A quarter turn about x takes +z to -y, then a stretch along y must not change that direction.
  spec.first_joint = {{"rotation", {half, 0, 0, half}}};
  spec.second_joint = {{"scale", {3, 1, 1}}};
  const Scene scene = skin_builder(spec).import();
  EXPECT_LT(glm::distance(scene.meshes.at(0)->normals[0], glm::vec3(0, -1, 0)), 1e-6f);
  EXPECT_LT(glm::distance(scene.meshes.at(0)->normals[1], glm::vec3(0, 0, 1)), 1e-6f);
}

TEST(Skin, AMirroringSkeletonKeepsTheOutsideOutside) {
  SkinSpec spec;
  spec.first_joint = {{"scale", {-1, 1, 1}}};
  spec.second_joint = {{"scale", {-1, 1, 1}}};
  const Scene scene = skin_builder(spec).import();
  const Mesh& mesh = *scene.meshes.at(0);
  const glm::vec3 a = mesh.positions[mesh.indices[0]], b = mesh.positions[mesh.indices[1]],
                  c = mesh.positions[mesh.indices[2]];
  EXPECT_GT(glm::dot(glm::cross(b - a, c - a), mesh.normals[0]), 0);
}

TEST(Skin, WeightsAreNormalisedAndTold) {
  SkinSpec spec;
  spec.second_joint = {{"translation", {0, 4, 0}}};
  spec.weights = {1, 0, 0, 0, 3, 0, 0, 0, 1, 1, 0, 0};
  const Scene scene = skin_builder(spec).import();
  EXPECT_THAT(scene.meshes.at(0)->positions,
              ElementsAre(glm::vec3(0), glm::vec3(1, 4, 0), glm::vec3(0, 3, 0)));
  EXPECT_THAT(note_codes(scene), ElementsAre("weights-repaired"));

  spec.weights = {1, 0, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0};
  const Scene without = skin_builder(spec).import();
  EXPECT_THAT(without.meshes.at(0)->positions,
              ElementsAre(glm::vec3(0), glm::vec3(1, 4, 0), glm::vec3(0, 1, 0)));
}

TEST(Skin, BothSetsCount) {
  SkinSpec spec;
  spec.second_joint = {{"translation", {0, 0, 8}}};
  spec.weights = {0.75f, 0, 0, 0, 0.75f, 0, 0, 0, 0.75f, 0, 0, 0};
  spec.joints = std::vector<std::uint8_t>(12, 0);
  GltfBuilder builder = skin_builder(spec);
  Json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_1"] = builder.add_accessor<std::uint16_t>("VEC4", std::vector<std::uint16_t>(12, 1));
  attributes["WEIGHTS_1"] =
      builder.add_accessor<float>("VEC4", {0.25f, 0, 0, 0, 0.25f, 0, 0, 0, 0.25f, 0, 0, 0});
  const Scene scene = builder.import();
  EXPECT_EQ(scene.meshes.at(0)->positions[0], glm::vec3(0, 0, 2));
  EXPECT_THAT(scene.notes, IsEmpty());
}

TEST(Skin, IsChecked) {
  SkinSpec spec;
  spec.joints[4] = 2;
  EXPECT_EQ(pointer_of_error(skin_builder(spec)), "/meshes/0/primitives/0/attributes/JOINTS_0");
  spec = {};
  spec.joints[1] = 200;  // its weight is 0
  EXPECT_EQ(pointer_of_error(skin_builder(spec)), "no error");
  spec = {};
  spec.weights[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(pointer_of_error(skin_builder(spec)), "/meshes/0/primitives/0/attributes/WEIGHTS_0");
  spec = {};
  spec.inverse_bind.assign(16, 0);
  EXPECT_EQ(pointer_of_error(skin_builder(spec)), "/skins/0/inverseBindMatrices");
  spec.inverse_bind.assign(32, std::numeric_limits<float>::infinity());
  EXPECT_EQ(pointer_of_error(skin_builder(spec)), "/skins/0/inverseBindMatrices");
}

TEST(Skin, SetsAreBounded) {
  GltfBuilder builder = skin_builder({});
  Json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  for (int set = 1; set < 20; ++set) {
    attributes["JOINTS_" + std::to_string(set)] = attributes["JOINTS_0"];
    attributes["WEIGHTS_" + std::to_string(set)] = attributes["WEIGHTS_0"];
  }
  EXPECT_EQ(error_of([&] { builder.import(); })->code, ErrorCode::kTooLarge);
}

TEST(Skin, WithoutJointsInTheMeshIsIgnored) {
  SkinSpec spec;
  spec.mesh_node = {{"translation", {100, 0, 0}}};
  GltfBuilder builder = skin_builder(spec);
  Json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  attributes.erase("JOINTS_0");
  EXPECT_EQ(pointer_of_error(builder), "/meshes/0/primitives/0/attributes");
  attributes.erase("WEIGHTS_0");
  const Scene scene = builder.import();
  EXPECT_EQ(scene.instances.at(0).world_from_model[3].x, 100);
  EXPECT_THAT(note_codes(scene), ElementsAre("skin-ignored"));
}

}  // namespace
}  // namespace furnace::testing
