// Seeded damage to small models: each ends in a Scene whose invariants hold or in an Error, never in a crash
// (the sanitizers of the asan preset see the rest).
#include <cmath>
#include <functional>
#include <random>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

// Skin, morph targets, sparse accessor, textures, indices, two UV sets: every reader has something to do.
ModelBundle rich_bundle() {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const int normal = builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv = builder.add_accessor<std::uint16_t>("VEC2", {0, 0, 65535, 0, 0, 65535, 65535, 65535}, true);
  const int color = builder.add_accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(16, 200), true);
  const int joints = builder.add_accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(16, 0));
  const int weights = builder.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const int indices = builder.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 2, 1, 3});
  const int morph = builder.add("accessors", {{"type", "VEC3"}, {"componentType", 5126}, {"count", 4}});
  builder.json["accessors"][morph]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", builder.add_view<std::uint8_t>({2})}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.add_view<float>({0, 0, 1})}}}};
  const int image = builder.add(
      "images", {{"bufferView", builder.add_view<std::uint8_t>({0x89, 'P', 'N', 'G', 13, 10, 26, 10})}});
  const int texture = builder.add("textures", {{"source", image}});
  const Json layers = {
      {"KHR_materials_ior", {{"ior", 1.5}}},
      {"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", texture}}}}},
      {"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}},
      {"KHR_materials_volume", {{"attenuationDistance", 1}, {"attenuationColor", {1, 0.5, 1}}}},
      {"KHR_materials_pbrSpecularGlossiness", {{"glossinessFactor", 0.5}}}};
  const int material =
      builder.add("materials", {{"normalTexture", {{"index", texture}}}, {"extensions", layers}});
  builder.json["extensions"]["KHR_materials_variants"]["variants"].push_back({{"name", "a"}});
  const Json mappings = Json::array({{{"material", material}, {"variants", {0}}}});
  const int skin = builder.add(
      "skins", {{"joints", {1}},
                {"inverseBindMatrices",
                 builder.add_accessor<float>("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})}});
  builder.show({{"attributes",
                 {{"POSITION", position},
                  {"NORMAL", normal},
                  {"TEXCOORD_0", uv},
                  {"COLOR_0", color},
                  {"JOINTS_0", joints},
                  {"WEIGHTS_0", weights}}},
                {"indices", indices},
                {"material", material},
                {"extensions", {{"KHR_materials_variants", {{"mappings", mappings}}}}},
                {"targets", {{{"POSITION", morph}}}}},
               {{"skin", skin}, {"weights", {0.5}}});
  builder.add("nodes", {{"translation", {0, 0, 1}}, {"rotation", {0, 0, 0, 1}}});
  builder.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
  builder.add("nodes", {{"camera", 0}});
  return builder.bundle();
}

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
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
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
  EXPECT_EQ(scene.meshes.at(0).positions[2], glm::vec3(0, 1, 1.5f));
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
