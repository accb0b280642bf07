// Seeded damage to small models: each ends in a Scene whose invariants hold or in an Error, never in a crash
// (the sanitizers of the asan preset see the rest).
#include <cmath>
#include <functional>
#include <random>

#include "tests/scene/gltf_samples.hpp"

namespace furnace::testing {
namespace {

template <class V>
void expect_whole(const std::vector<V>& values, const Mesh& mesh, bool required) {
  EXPECT_TRUE(values.size() == mesh.positions.size() || (values.empty() && !required));
  for (const V& value : values) {
    for (int i = 0; i < V::length(); ++i) EXPECT_TRUE(std::isfinite(value[i]));
  }
}

void expect_invariants(const Scene& scene) {
  EXPECT_FALSE(scene.materials.empty());
  for (const Instance& instance : scene.instances) {
    EXPECT_LT(static_cast<std::size_t>(instance.mesh), scene.meshes.size());
    EXPECT_LT(static_cast<std::size_t>(instance.material), scene.materials.size());
    const Mesh& mesh = *scene.meshes[static_cast<std::size_t>(instance.mesh)];
    const bool mapped =
        scene.materials[static_cast<std::size_t>(instance.material)].texture(TextureUse::kNormal).has_value();
    const bool triangles = mesh.topology == Topology::kTriangles;
    EXPECT_FALSE(mesh.indices.empty());
    for (const std::uint32_t index : mesh.indices) EXPECT_LT(index, mesh.positions.size());
    expect_whole(mesh.positions, mesh, true);
    expect_whole(mesh.normals, mesh, triangles);
    expect_whole(mesh.tangents, mesh, triangles && mapped);
    expect_whole(mesh.uvs[0], mesh, mapped);
    expect_whole(mesh.colors, mesh, false);
    const Bounds bounds = world_bounds(scene);
    EXPECT_TRUE(std::isfinite(bounds.min.x) && std::isfinite(bounds.max.z));
  }
}

// 1 when a scene came out.
int import_damaged(const ModelBundle& bundle) {
  try {
    expect_invariants(import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline()));
    return 1;
  } catch (const Error& error) {
    EXPECT_NE(error.code, ErrorCode::kInternal) << error.message;
    return 0;
  }
}

std::string flipped(std::string bytes, std::mt19937& random, int flips) {
  for (int i = 0; i < flips && !bytes.empty(); ++i) {
    bytes[random() % bytes.size()] ^= static_cast<char>(1u << (random() % 8));
  }
  return bytes;
}

constexpr int kRounds = 1000;

TEST(Fuzz, TheUndamagedModelIsRich) {
  const Scene scene = import_gltf(decode::in_process_decoder(), rich_bundle(), {}, {}, Deadline());
  expect_invariants(scene);
  EXPECT_EQ(scene.meshes.at(0)->positions[2], glm::vec3(0, 1, 1.5f));
}

TEST(Fuzz, FlippedBitsOfTheDocument) {
  const ModelBundle whole = rich_bundle();
  std::mt19937 random(1);
  int scenes = 0;
  for (int round = 0; round < kRounds; ++round) {
    ModelBundle bundle = whole;
    bundle.document = Blob(flipped(std::string(whole.document.text()), random, 1 + round % 3));
    scenes += import_damaged(bundle);
  }
  EXPECT_GT(scenes, 0);
  EXPECT_LT(scenes, kRounds);
}

TEST(Fuzz, FlippedBitsOfTheBuffer) {
  const ModelBundle whole = rich_bundle();
  std::mt19937 random(2);
  int scenes = 0;
  for (int round = 0; round < kRounds; ++round) {
    ModelBundle bundle = whole;
    bundle.siblings["data.bin"] = Blob(flipped(std::string(whole.siblings.at("data.bin").text()), random, 8));
    scenes += import_damaged(bundle);
  }
  EXPECT_GT(scenes, 0);
  EXPECT_LT(scenes, kRounds);
}

TEST(Fuzz, TruncatedFiles) {
  const ModelBundle whole = rich_bundle();
  for (std::size_t size = 0; size < whole.document.size(); size += 3) {
    ModelBundle bundle = whole;
    bundle.document = Blob(std::string(whole.document.text().substr(0, size)));
    EXPECT_EQ(import_damaged(bundle), 0);
  }
  for (std::size_t size = 0; size < whole.siblings.at("data.bin").size(); ++size) {
    ModelBundle bundle = whole;
    bundle.siblings["data.bin"] = Blob(std::string(whole.siblings.at("data.bin").text().substr(0, size)));
    EXPECT_EQ(import_damaged(bundle), 0);
  }
}

// Every number of the document replaced by awkward ones, one at a time.
void for_each_number(Json& value, const std::function<void(Json&)>& visit) {
  if (value.is_number()) return visit(value);
  if (!value.is_structured()) return;
  for (auto& member : value) for_each_number(member, visit);
}

TEST(Fuzz, AwkwardNumbers) {
  const ModelBundle whole = rich_bundle();
  Json document = Json::parse(whole.document.text());
  const std::vector<Json> awkward{-1,
                                  0,
                                  1,
                                  2,
                                  3,
                                  0.5,
                                  255,
                                  65536,
                                  4294967295ull,
                                  4294967296ull,
                                  9007199254740992ull,
                                  18446744073709551615ull,
                                  -9223372036854775807ll,
                                  1e38,
                                  -1e308,
                                  nullptr,
                                  "0",
                                  true};
  int scenes = 0;
  for_each_number(document, [&](Json& number) {
    const Json kept = number;
    for (const Json& other : awkward) {
      number = other;
      ModelBundle bundle = whole;
      bundle.document = Blob(document.dump());
      scenes += import_damaged(bundle);
    }
    number = kept;
  });
  EXPECT_GT(scenes, 0);
}

}  // namespace
}  // namespace furnace::testing
