// KHR_draco_mesh_compression: meshes that Draco's own encoder wrote come back, damage and lies are refused.
#include "renderer/scene/draco_decode.hpp"

#include <cmath>
#include <set>
#include <random>

#include "renderer/scene/gltf_accessor.hpp"
#include "tests/scene/draco_grid.hpp"
#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

// Draco sorts vertices anew: each is told by its place on the grid.
int grid_index(const glm::vec3& position) {
  return int(std::lround(position.x)) + kSide * int(std::lround(position.y));
}

class Draco : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Methods, Draco, ::testing::Bool());

TEST_P(Draco, BringsBackVerticesAndTriangles) {
  const std::string file = encoded_grid(GetParam());
  const DracoMesh mesh = decode_draco(bytes_of(file), grid_request());
  ASSERT_EQ(mesh.indices.size(), 3 * kTriangles);
  ASSERT_EQ(mesh.attributes.size(), 2u);
  ASSERT_EQ(mesh.attributes[0].size(), kVertices * sizeof(glm::vec3));
  ASSERT_EQ(mesh.attributes[1].size(), kVertices * 4);
  const auto* positions = reinterpret_cast<const glm::vec3*>(mesh.attributes[0].data());
  std::set<int> seen;
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    const int place = grid_index(positions[i]);
    seen.insert(place);
    EXPECT_LT(glm::distance(positions[i], grid_position(place)), 8.0f / (1 << 13));
    const std::array<std::uint8_t, 4> joints = grid_joints(place);
    EXPECT_EQ(std::memcmp(mesh.attributes[1].data() + i * 4, joints.data(), 4), 0);
  }
  EXPECT_EQ(seen.size(), kVertices);
  double area = 0;  // every triangle is half a square of the grid, counter-clockwise
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::vec3 a = positions[mesh.indices[i]], b = positions[mesh.indices[i + 1]],
                    c = positions[mesh.indices[i + 2]];
    const double twice = double(b.x - a.x) * (c.y - a.y) - double(c.x - a.x) * (b.y - a.y);
    EXPECT_NEAR(twice, 1, 0.01);
    area += twice / 2;
  }
  EXPECT_NEAR(area, (kSide - 1) * (kSide - 1), 0.01);
}

TEST_P(Draco, RefusesWhatTheAccessorsDoNotSay) {
  const std::string file = encoded_grid(GetParam());
  const auto code = [&](const DracoRequest& request) {
    const auto error = error_of([&] { decode_draco(bytes_of(file), request); });
    return error ? error_code_name(error->code) : "none";
  };
  DracoRequest request = grid_request();
  request.vertices = kVertices + 1;
  EXPECT_EQ(code(request), "unprocessable");
  request = grid_request();
  request.vertices = kVertices - 1;
  EXPECT_EQ(code(request), "unprocessable");
  request = grid_request();
  request.most_triangles = kTriangles - 1;
  EXPECT_EQ(code(request), "unprocessable");
  request = grid_request();
  request.attributes[0].id = 7;
  EXPECT_EQ(code(request), "unprocessable");
  request = grid_request();
  request.attributes[0].components = 2;
  EXPECT_EQ(code(request), "unprocessable");
  request = grid_request();
  request.most_bytes = 1000;
  EXPECT_EQ(code(request), "too-large");
}

TEST_P(Draco, DamageEndsInAMeshOrAnError) {
  const std::string file = encoded_grid(GetParam());
  for (std::size_t size = 0; size < file.size(); ++size) {
    const std::string cut = file.substr(0, size);
    EXPECT_TRUE(error_of([&] { decode_draco(bytes_of(cut), grid_request()); }) || size + 8 > file.size())
        << size;
  }
  std::mt19937 random(3);
  int meshes = 0;
  for (int round = 0; round < 2000; ++round) {
    std::string broken = file;
    for (int i = 0; i <= round % 3; ++i) broken[random() % broken.size()] ^= char(1u << (random() % 8));
    const auto error = error_of([&] {
      for (const std::uint32_t index : decode_draco(bytes_of(broken), grid_request()).indices)
        EXPECT_LT(index, kVertices);
      ++meshes;
    });
    EXPECT_TRUE(!error || error->code != ErrorCode::kInternal);
  }
  EXPECT_GT(meshes, 0);
  EXPECT_LT(meshes, 2000);
}

TEST(DracoBomb, ManyTrianglesNeedManyBytes) {
  // Sequential: counts of 60 million triangles and 3 vertices, then nothing.
  std::string file("DRACO\x02\x02\x01\x00\x00\x00", 11);
  for (const std::uint32_t count : {60'000'000u, 3u}) {
    std::uint32_t rest = count;
    for (; rest > 127; rest >>= 7) file.push_back(char((rest & 127) | 128));
    file.push_back(char(rest));
  }
  DracoRequest request;
  request.vertices = 3;
  request.most_triangles = 100'000'000;
  const auto error = error_of([&] { decode_draco(bytes_of(file), request); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kTooLarge);
}

Json& draco_of(GltfBuilder& builder) {
  return primitive_of(builder)["extensions"]["KHR_draco_mesh_compression"];
}

TEST(DracoDocument, GivesThePrimitiveItsVertices) {
  const Scene scene = grid_document().import();
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0]->indices.size(), 3 * kTriangles);
  EXPECT_NEAR(world_bounds(scene).max.x, kSide - 1, 0.01);
  EXPECT_EQ(note_codes(scene), std::vector<std::string>{"normals-generated"});
}

TEST(DracoDocument, GoesBeforeAccessorsThatHaveBytesToo) {
  GltfBuilder builder = grid_document();
  builder.json["accessors"][0]["bufferView"] = builder.add_view(std::vector<float>(3 * kVertices, -5.0f));
  builder.json["accessors"][1]["bufferView"] =
      builder.add_view(std::vector<std::uint16_t>(3 * kTriangles, 0));
  const Scene scene = builder.import();
  EXPECT_NEAR(world_bounds(scene).min.x, 0, 0.01);
  EXPECT_EQ(scene.meshes[0]->indices.size(), 3 * kTriangles);
}

TEST(DracoDocument, TakesOtherAttributesAndTargetsFromAccessors) {
  GltfBuilder builder = grid_document();
  std::vector<float> normals, targets;
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    normals.insert(normals.end(), {0, 0, 1});
    targets.insert(targets.end(), {0, 0, 100});
  }
  Json& primitive = primitive_of(builder);
  primitive["attributes"]["NORMAL"] = builder.add_accessor<float>("VEC3", normals);
  primitive["targets"].push_back({{"POSITION", builder.add_accessor<float>("VEC3", targets)}});
  builder.json["meshes"][0]["weights"] = {0.5};
  const Scene scene = builder.import();
  EXPECT_EQ(scene.meshes[0]->normals.size(), kVertices);
  EXPECT_NEAR(world_bounds(scene).min.z, 50 + grid_position(7).z, 1);
  EXPECT_EQ(note_codes(scene), std::vector<std::string>{});
}

// A strip's indices would be unrolled from the triangles; its accessor has two more than triangles.
TEST(DracoDocument, StripsAreTriangles) {
  GltfBuilder builder = grid_document();
  primitive_of(builder)["mode"] = 5;
  builder.json["accessors"][1]["count"] = kTriangles + 2;
  EXPECT_EQ(builder.import().meshes.at(0)->indices.size(), 3 * kTriangles);
}

TEST(DracoDocument, AttributesShareAnAccessor) {
  GltfBuilder builder = grid_document();
  primitive_of(builder)["attributes"]["_CUSTOM"] = 0;
  draco_of(builder)["attributes"]["_CUSTOM"] = 12;                             // never read
  EXPECT_EQ(builder.import().meshes.at(0)->positions.size(), 3 * kTriangles);  // flat: vertices of their own
}

TEST(DracoDocument, RefusesWhatCannotBe) {
  const std::string at = "/meshes/0/primitives/0", extension = at + "/extensions/KHR_draco_mesh_compression";
  GltfBuilder builder = grid_document();
  primitive_of(builder)["mode"] = 1;
  EXPECT_EQ(pointer_of_error(builder), at + "/mode");
  builder = grid_document();
  primitive_of(builder).erase("indices");
  EXPECT_EQ(pointer_of_error(builder), at);
  builder = grid_document();
  draco_of(builder)["attributes"]["NORMAL"] = 1;
  EXPECT_EQ(pointer_of_error(builder), extension + "/attributes/NORMAL");
  builder = grid_document();
  draco_of(builder)["bufferView"] = 1;
  EXPECT_EQ(pointer_of_error(builder), extension + "/bufferView");
  builder = grid_document();
  builder.json["accessors"][0]["count"] = 1'000'000'000;
  EXPECT_EQ(pointer_of_error(builder), at);  // the limit of vertices
  builder = grid_document();
  builder.json["accessors"][0]["count"] = kVertices + 1;
  EXPECT_EQ(pointer_of_error(builder), extension);
}

// An accessor that a compressed mesh fills counts no zeros, until something else reads it.
TEST(DracoDocument, ZerosStayBounded) {
  GltfBuilder builder = grid_document();
  builder.json["accessors"][0]["count"] = 10'000'000;
  const auto error = error_of([&] {
    const ModelBundle bundle = builder.bundle();
    const GltfDocument document = read_gltf_document(bundle.document, {});
    GltfData(document, bundle, ImportLimits(), decode::in_process_decoder(), Deadline())
        .read_vectors<glm::vec3>(0);
  });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->pointer, "/accessors/0/count");
}

}  // namespace
}  // namespace furnace::testing
