#include <gmock/gmock.h>

#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/gltf_read.hpp"
#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const glm::vec3 kRight(1, 0, 0), kUp(0, 1, 0), kTowardsViewer(0, 0, 1);

glm::vec3 transformed(const Instance& instance, const glm::vec3& point) {
  return glm::vec3(instance.world_from_model * glm::vec4(point, 1));
}

TEST(Import, ATriangleComesOutAsWritten) {
  const Scene scene = clean_builder({{"name", "tri"}}).import();
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = *scene.meshes[0];
  EXPECT_THAT(mesh.positions, ElementsAre(glm::vec3(0), kRight, kUp));
  EXPECT_THAT(mesh.normals, ElementsAre(kTowardsViewer, kTowardsViewer, kTowardsViewer));
  EXPECT_EQ(mesh.uvs[1][0], glm::vec2(0.5f, 0));
  EXPECT_THAT(mesh.indices, ElementsAre(0u, 1u, 2u));
  EXPECT_EQ(mesh.bounds.min, glm::vec3(0));
  EXPECT_EQ(mesh.bounds.max, glm::vec3(1, 1, 0));
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].node_name, "tri");
  EXPECT_EQ(scene.materials.size(), 1u);  // the default one
  EXPECT_THAT(scene.notes, IsEmpty());
}

TEST(Import, FlatNormalsAreMadeWhenThereAreNone) {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  const int index = builder.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 0, 2, 3});
  builder.show({{"attributes", {{"POSITION", position}}}, {"indices", index}});
  const Scene scene = builder.import();
  const Mesh& mesh = *scene.meshes.at(0);
  EXPECT_EQ(mesh.positions.size(), 6u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(mesh.normals[mesh.indices[i]], kTowardsViewer);
  for (int i = 3; i < 6; ++i) EXPECT_EQ(mesh.normals[mesh.indices[i]], kRight);
  EXPECT_THAT(note_codes(scene), ElementsAre("normals-generated"));
}

TEST(Import, BrokenNormalsAreRepaired) {
  GltfBuilder builder = clean_builder();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float huge = std::numeric_limits<float>::max();
  primitive_of(builder)["attributes"]["NORMAL"] =
      builder.add_accessor<float>("VEC3", {0, 0, 0, nan, 0, 1, 0, 0, huge});
  const Scene scene = builder.import();
  EXPECT_THAT(scene.meshes.at(0)->normals, ElementsAre(kTowardsViewer, kTowardsViewer, kTowardsViewer));
  EXPECT_EQ(find_note(scene, "normals-repaired")->pointer, "/meshes/0/primitives/0/attributes/NORMAL");
}

TEST(Import, PositionsMustBeFinite) {
  GltfBuilder builder;
  const int position =
      builder.add_accessor<float>("VEC3", {0, 0, 0, std::numeric_limits<float>::infinity(), 0, 0, 0, 1, 0});
  builder.show({{"attributes", {{"POSITION", position}}}});
  EXPECT_EQ(pointer_of_error(builder), "/meshes/0/primitives/0/attributes/POSITION");
}

TEST(Import, OtherValuesThatAreNotFiniteAreReplaced) {
  GltfBuilder builder = clean_builder();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  primitive_of(builder)["attributes"]["TEXCOORD_0"] =
      builder.add_accessor<float>("VEC2", {nan, 0, 1, 0, 0, 1});
  primitive_of(builder)["attributes"]["COLOR_0"] =
      builder.add_accessor<float>("VEC3", {0.5f, 0.5f, 0.5f, nan, 0, 0, 0, 0, 0});
  const Scene scene = builder.import();
  EXPECT_EQ(scene.meshes[0]->uvs[0][0], glm::vec2(0));
  EXPECT_THAT(scene.meshes[0]->colors,
              ElementsAre(glm::vec4(0.5f, 0.5f, 0.5f, 1), glm::vec4(1), glm::vec4(0, 0, 0, 1)));
  EXPECT_THAT(note_codes(scene), ElementsAre("attribute-repaired", "attribute-repaired"));
}

TEST(Import, VerticesThatNothingNamesAreDropped) {
  GltfBuilder builder;
  const int position =
      builder.add_accessor<float>("VEC3", {100, 100, 100, 0, 0, 0, 200, 0, 0, 1, 0, 0, 0, 1, 0, -100, 0, 0});
  const int normal =
      builder.add_accessor<float>("VEC3", {1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0});
  const int index = builder.add_accessor<std::uint8_t>("SCALAR", {1, 3, 4});
  builder.show({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}, {"indices", index}});
  const Scene scene = builder.import();
  EXPECT_THAT(scene.meshes[0]->positions, ElementsAre(glm::vec3(0), kRight, kUp));
  EXPECT_THAT(scene.meshes[0]->normals, ElementsAre(kTowardsViewer, kTowardsViewer, kTowardsViewer));
  EXPECT_THAT(scene.meshes[0]->indices, ElementsAre(0u, 1u, 2u));
  EXPECT_EQ(world_bounds(scene).max, glm::vec3(1, 1, 0));
}

TEST(Import, IndicesAreCheckedAndRestartRefused) {
  for (const std::uint8_t bad : {std::uint8_t{3}, std::uint8_t{255}}) {
    GltfBuilder builder = clean_builder();
    primitive_of(builder)["indices"] = builder.add_accessor<std::uint8_t>("SCALAR", {0, 1, bad});
    EXPECT_EQ(pointer_of_error(builder), "/meshes/0/primitives/0/indices");
  }
}

TEST(Import, NodesComposeParentsBeforeChildren) {
  // Turned a quarter about +z, then moved: (1, 0, 0) -> scale 2 -> (2, 0, 0) -> (0, 2, 0) -> (5, 2, 0).
  GltfBuilder builder = clean_builder({{"scale", {2, 2, 2}}});
  const double half = std::sqrt(0.5);
  builder.add("nodes", {{"translation", {5, 0, 0}}, {"rotation", {0, 0, half, half}}, {"children", {0}}});
  const Scene scene = builder.import();
  const glm::vec3 point = transformed(scene.instances.at(0), kRight);
  EXPECT_LT(glm::distance(point, glm::vec3(5, 2, 0)), 1e-6f);
}

TEST(Import, AMatrixIsColumnMajor) {
  const Scene scene = clean_builder({{"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}}}).import();
  EXPECT_EQ(transformed(scene.instances.at(0), kRight), glm::vec3(6, 8, 9));
  EXPECT_LT(glm::determinant(glm::mat3(scene.instances[0].world_from_model)), 0);
  EXPECT_THAT(scene.meshes[0]->indices, ElementsAre(0u, 1u, 2u));  // winding is the renderer's business
}

TEST(Import, UnevenRotationsAreNormalised) {
  const Scene scene = clean_builder({{"rotation", {0, 0, 0, 2}}}).import();
  EXPECT_EQ(transformed(scene.instances.at(0), kRight), kRight);
  EXPECT_EQ(find_note(scene, "rotation-repaired")->pointer, "/nodes/0/rotation");
}

TEST(Import, AMeshUsedTwiceIsOneMesh) {
  GltfBuilder builder = clean_builder();
  builder.add("nodes", {{"mesh", 0}, {"translation", {3, 0, 0}}});
  const Scene scene = builder.import();
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.instances[0].mesh, scene.instances[1].mesh);
  EXPECT_EQ(world_bounds(scene).max, glm::vec3(4, 1, 0));
}

TEST(Import, ScenesAreChosenByIndexDefaultAndOrder) {
  GltfBuilder builder = clean_builder({{"name", "a"}});
  builder.add("nodes", {{"mesh", 0}, {"name", "b"}});
  builder.add("nodes", {{"mesh", 0}, {"name", "c"}});
  const auto names = [&](int scene) {
    std::string result;
    for (const Instance& instance : builder.import({scene, {}}).instances) result += instance.node_name;
    return result;
  };
  EXPECT_EQ(names(-1), "abc");  // no scenes: all roots
  builder.json["scenes"] = {{{"nodes", {2, 0}}}, {{"nodes", {1}}}};
  EXPECT_EQ(names(-1), "ca");
  EXPECT_EQ(names(1), "b");
  builder.json["scene"] = 1;
  EXPECT_EQ(names(-1), "b");
  EXPECT_EQ(names(0), "ca");
  EXPECT_EQ(error_of([&] { builder.import({2, {}}); })->pointer, "/scenes");
}

TEST(Import, HashTellsScenesAndFilesApart) {
  const GltfBuilder builder = clean_builder();
  const ContentHash hash = builder.import().hash;
  EXPECT_EQ(builder.import().hash, hash);
  EXPECT_NE(clean_builder({{"name", "x"}}).import().hash, hash);
}

TEST(Import, CamerasStandWithoutScale) {
  GltfBuilder builder = clean_builder();
  builder.add("cameras", {{"type", "perspective"},
                          {"perspective", {{"yfov", 0.5}, {"znear", 0.1}, {"aspectRatio", 2}}}});
  builder.add("cameras", {{"type", "orthographic"},
                          {"name", "flat"},
                          {"orthographic", {{"xmag", -3}, {"ymag", 2}, {"znear", 0}, {"zfar", 9}}}});
  const double half = std::sqrt(0.5);
  builder.add("nodes", {{"camera", 1}});
  builder.add("nodes", {{"camera", 0},
                        {"name", "eye"},
                        {"translation", {1, 2, 3}},
                        {"scale", {4, 4, 4}},
                        {"rotation", {0, half, 0, half}}});
  const Scene scene = builder.import();
  ASSERT_EQ(scene.cameras.size(), 2u);
  const CameraNode& eye = scene.cameras[0];
  EXPECT_EQ(eye.name, "eye");
  EXPECT_DOUBLE_EQ(eye.fov_y_rad, 0.5);
  EXPECT_DOUBLE_EQ(eye.z_near, 0.1);
  EXPECT_DOUBLE_EQ(*eye.aspect_ratio, 2);
  EXPECT_FALSE(eye.z_far);
  // Looks along -z of its own, a quarter turn about +y: along -x.
  EXPECT_LT(glm::distance(glm::vec3(eye.world_from_view * glm::vec4(0, 0, -1, 0)), -kRight), 1e-6f);
  EXPECT_LT(glm::distance(glm::vec3(eye.world_from_view * glm::vec4(0, 1, 0, 0)), kUp), 1e-6f);
  EXPECT_EQ(glm::vec3(eye.world_from_view[3]), glm::vec3(1, 2, 3));
  const CameraNode& flat = scene.cameras[1];
  EXPECT_EQ(flat.name, "flat");
  EXPECT_TRUE(flat.orthographic);
  EXPECT_DOUBLE_EQ(flat.half_width, 3);
  EXPECT_DOUBLE_EQ(flat.half_height, 2);
  EXPECT_DOUBLE_EQ(*flat.z_far, 9);
}

TEST(Import, SuppliedTangentsAreKeptOnlyWithNormals) {
  GltfBuilder builder = clean_builder();
  const int tangent = builder.add_accessor<float>("VEC4", {0, 2, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1});
  primitive_of(builder)["attributes"]["TANGENT"] = tangent;
  EXPECT_THAT(builder.import().meshes[0]->tangents, ::testing::Each(glm::vec4(0, 1, 0, 1)));
  primitive_of(builder)["attributes"].erase("NORMAL");
  EXPECT_THAT(builder.import().meshes[0]->tangents, IsEmpty());
}

TEST(Import, QuantizedAttributesNeedTheirExtension) {
  GltfBuilder builder;
  const int position = builder.add_accessor<std::uint8_t>("VEC3", {0, 0, 0, 255, 0, 0, 0, 255, 0}, true);
  builder.show({{"attributes", {{"POSITION", position}}}});
  EXPECT_EQ(pointer_of_error(builder), "/meshes/0/primitives/0/attributes/POSITION");
  builder.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  EXPECT_THAT(builder.import().meshes[0]->positions, ElementsAre(glm::vec3(0), kRight, kUp));
}

TEST(Import, ExtensionsAreIgnoredOrRefused) {
  GltfBuilder builder = clean_builder();
  builder.json["extensionsUsed"] = {"KHR_texture_transform", "VENDOR_a", "VENDOR_b"};
  const Scene scene = builder.import();
  EXPECT_THAT(note_codes(scene), ElementsAre("extension-ignored", "extension-ignored"));
  EXPECT_EQ(scene.notes[0].pointer, "/extensionsUsed/1");
  builder.json["extensionsRequired"] = {"KHR_texture_transform", "VENDOR_b"};
  EXPECT_EQ(pointer_of_error(builder), "/extensionsRequired/1");
}

TEST(Import, PrimitivesThatDrawNothingAreSkipped) {
  GltfBuilder builder = clean_builder();
  const int point = builder.add_accessor<float>("VEC3", {1, 2, 3});
  Json& primitives = builder.json["meshes"][0]["primitives"];
  primitives.push_back({{"attributes", {{"_CUSTOM", point}}}});
  primitives.push_back({{"attributes", {{"POSITION", point}}}});
  primitives.push_back({{"attributes", {{"POSITION", point}}}, {"mode", 0}});
  const Scene scene = builder.import();
  EXPECT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[1]->topology, Topology::kPoints);
  EXPECT_THAT(note_codes(scene), ElementsAre("primitive-skipped", "primitive-skipped"));
}

TEST(Import, LimitsHold) {
  GltfBuilder builder = clean_builder();
  builder.add("nodes", {{"mesh", 0}});
  ImportLimits limits;
  EXPECT_EQ(pointer_of_error(builder, limits), "no error");
  const auto refusal = [&](auto&& tighten) {
    ImportLimits tight;
    tighten(tight);
    const auto error = error_of([&] { builder.import({}, tight); });
    return error && error->code == ErrorCode::kTooLarge ? error->pointer : "not too large";
  };
  EXPECT_EQ(refusal([](ImportLimits& l) { l.max_triangles = 1; }), "/nodes/1");  // drawn twice
  EXPECT_EQ(refusal([](ImportLimits& l) { l.max_vertices = 2; }), "/meshes/0/primitives/0");
  EXPECT_EQ(refusal([](ImportLimits& l) { l.max_mesh_bytes = 100; }), "/meshes/0/primitives/0");
  EXPECT_EQ(refusal([](ImportLimits& l) { l.max_nodes = 1; }), "/nodes");
  EXPECT_EQ(refusal([](ImportLimits& l) { l.max_json_bytes = 100; }), "");
  EXPECT_EQ(refusal([](ImportLimits& l) { l.max_buffer_bytes = 100; }), "/buffers");
}

TEST(Import, ADeepHierarchyNeedsNoStack) {
  GltfBuilder builder;
  constexpr int kDepth = 50'000;
  for (int i = 0; i + 1 < kDepth; ++i) builder.add("nodes", {{"children", {i + 1}}});
  builder.add("nodes", Json::object());
  EXPECT_EQ(error_of([&] { builder.import(); })->code, ErrorCode::kTooLarge);
  ImportLimits limits;
  limits.max_node_depth = kDepth;
  EXPECT_EQ(pointer_of_error(builder, limits), "no error");
}

TEST(Import, ImpliedZerosAreBounded) {
  GltfBuilder builder;
  builder.add("accessors", {{"type", "VEC3"}, {"componentType", 5126}, {"count", 1'000'000'000}});
  const auto error = error_of([&] { builder.import(); });
  EXPECT_EQ(error->code, ErrorCode::kTooLarge);
  EXPECT_EQ(error->pointer, "/accessors/0/count");
}

TEST(Import, WhatIsNoModelIsSaidToBeNone) {
  const auto message_of = [](const std::string& bytes) {
    return error_of([&] { gltf_external_uris(Blob(bytes), {}); })->message;
  };
  EXPECT_TRUE(message_of("Kaydara FBX Binary  ").ends_with("it is an FBX file"));
  EXPECT_TRUE(message_of("<!DOCTYPE html>").ends_with("it is a web page"));
  EXPECT_TRUE(message_of(" ").ends_with("it is empty"));
  EXPECT_TRUE(message_of("anything").starts_with("is no model that is read here"));
  EXPECT_TRUE(message_of("{").starts_with("not JSON"));
}

TEST(Import, UndeclaredExtensionsAreToldWhereTheyStand) {
  GltfBuilder builder = clean_builder();
  builder.json["nodes"][0]["extensions"] = {{"MAKER_a/b", Json::object()},
                                            {"KHR_node_visibility", Json::object()}};
  builder.json["asset"]["extras"]["extensions"]["NOT_one"] = Json::object();
  const Scene scene = builder.import();
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_EQ(scene.notes[0].pointer, "/nodes/0/extensions/MAKER_a~1b");
  GltfBuilder many = clean_builder();
  for (int i = 0; i < 2000; ++i)
    many.json["nodes"][0]["extensions"]["E" + std::to_string(i)] = Json::object();
  EXPECT_EQ(undeclared_extensions(many.json).size(), kMostUndeclared);
  builder.json["extensionsUsed"] = {"MAKER_a/b"};
  EXPECT_EQ(builder.import().notes.at(0).pointer, "/extensionsUsed/0");
}

TEST(Import, WhatLiesTooFarForSinglePrecisionIsTold) {
  GltfBuilder builder = clean_builder();
  for (const double distance : {0.0, 1e3}) {
    builder.json["nodes"][0]["translation"] = {distance, 0, 0};
    EXPECT_THAT(builder.import().notes, IsEmpty()) << distance;
  }
  builder.json["nodes"][0]["translation"] = {0, -1e5, 0};
  const Scene scene = builder.import();
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_EQ(scene.notes[0].code, "far-from-origin");
  builder.json["nodes"][0]["scale"] = {1e3, 1e3, 1e3};
  EXPECT_THAT(builder.import().notes, IsEmpty());
}

TEST(Notes, EndWithHowManyAreTold) {
  GltfNotes notes;
  for (int i = 0; i < 300; ++i) notes.add("code", std::to_string(i), "message");
  const std::vector<Note> told = notes.take();
  ASSERT_EQ(told.size(), 201u);
  EXPECT_EQ(told[199].code, "code");
  EXPECT_EQ(told[200].code, "notes-omitted");
}

TEST(Import, DeepOrEndlessJsonIsRefused) {
  const auto code_of = [](const std::string& text) {
    return error_of([&] { gltf_external_uris(Blob(text), {}); })->code;
  };
  EXPECT_EQ(code_of(std::string(1'000'000, '[')), ErrorCode::kTooLarge);
  std::string nested = R"({"extras":)";
  for (int i = 0; i < 10'000; ++i) nested += R"({"a":)";
  EXPECT_EQ(code_of(nested), ErrorCode::kTooLarge);
  std::string many = R"({"asset":{"version":"2.0"},"extras":[0)";
  for (int i = 0; i < 5'000'000; ++i) many += ",0";
  EXPECT_EQ(code_of(many + "]}"), ErrorCode::kTooLarge);
  EXPECT_EQ(code_of(R"({"asset":{"version":"2.0"},"x":1e999})"), ErrorCode::kUnprocessable);
  EXPECT_EQ(code_of("\"[[[["), ErrorCode::kUnprocessable);
}

TEST(Import, AMissingBufferIsAnError) {
  ModelBundle bundle = clean_builder().bundle();
  bundle.siblings.clear();
  const auto error = error_of([&] { import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline()); });
  EXPECT_EQ(error->code, ErrorCode::kUnprocessable);
  EXPECT_EQ(error->pointer, "/buffers/0/uri");
}

TEST(Import, StopsAtItsDeadline) {
  const auto error = error_of([] {
    import_gltf(decode::in_process_decoder(), clean_builder().bundle(), {}, {},
                Deadline(std::chrono::milliseconds(-1)));
  });
  EXPECT_EQ(error->code, ErrorCode::kDeadlineExceeded);
}

}  // namespace
}  // namespace furnace::testing
