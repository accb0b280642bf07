// A request's materials, textures and variant over those of a model and of built-in meshes.
#include "renderer/compose.hpp"

#include <gmock/gmock.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TextureFile file(std::string bytes) {
  TextureFile texture;
  texture.encoded = Blob(std::move(bytes));
  return texture;
}

TextureOverride& texture(SceneSpec& spec, const std::string& material, TextureUse use) {
  return spec.materials[material].textures[std::size_t(use)];
}

// One bare triangle that wears "skin", which has two textures of its own.
Scene model() {
  Scene scene;
  Mesh mesh;
  mesh.name = "triangle";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, glm::vec3(0, 0, 1));
  mesh.indices = {0, 1, 2};
  scene.meshes = {std::make_shared<const Mesh>(std::move(mesh))};
  scene.images = {{Blob(std::string("own")), "/images/0"}};
  Material material;
  material.name = "skin";
  material.texture(TextureUse::kBaseColor) = TextureSlot{0, 0, {}, {}};
  material.texture(TextureUse::kMetallicRoughness) = TextureSlot{0, 0, {}, {}};
  scene.materials = {material};
  scene.instances = {Instance{}};
  scene.variants = {"day", "night"};
  return scene;
}

SceneSpec sphere_of(const std::string& material) {
  SceneSpec spec;
  spec.nodes = {NodeSpec{.mesh = "sphere", .material = material}};
  return spec;
}

const Note* find_note(const ComposedScene& composed, std::string_view code) {
  for (const Note& note : composed.scene.notes)
    if (note.code == code) return &note;
  return nullptr;
}

TEST(Compose, TexturesOfARequestAreAddedSharedAndKnowTheirPlace) {
  SceneSpec spec = sphere_of("a/b");
  texture(spec, "a/b", TextureUse::kBaseColor) = file("wood");
  texture(spec, "a/b", TextureUse::kSheenColor) = file("wood");
  texture(spec, "a/b", TextureUse::kThickness) = file("thin");
  const ComposedScene composed = compose_scene(spec, nullptr);
  const Material& material = composed.scene.materials.at(0);
  ASSERT_THAT(composed.scene.images, SizeIs(2));
  EXPECT_EQ(material.texture(TextureUse::kBaseColor)->image, 0);
  EXPECT_EQ(material.texture(TextureUse::kSheenColor)->image, 0);
  EXPECT_EQ(material.texture(TextureUse::kThickness)->image, 1);
  EXPECT_EQ(composed.scene.images[0].pointer, "/scene/materials/a~1b/textures/baseColor");
  EXPECT_EQ(composed.scene.images[1].encoded.text(), "thin");
  EXPECT_THAT(composed.scene.notes, IsEmpty());
}

TEST(Compose, TexturesKeepReplaceOrRemoveTheModels) {
  const Scene scene = model();
  SceneSpec spec;
  texture(spec, "skin", TextureUse::kBaseColor) = NoTexture{};
  TextureFile roughness = file("rough");
  roughness.transform.scale = {2, 3};
  roughness.sampler.wrap_u = Wrap::kClampToEdge;
  texture(spec, "skin", TextureUse::kOcclusion) = roughness;
  const ComposedScene composed = compose_scene(spec, &scene);
  const Material& material = composed.scene.materials[0];
  EXPECT_FALSE(material.texture(TextureUse::kBaseColor));
  EXPECT_EQ(material.texture(TextureUse::kMetallicRoughness)->image, 0);
  const TextureSlot slot{1, 0, roughness.sampler, roughness.transform};
  EXPECT_EQ(material.texture(TextureUse::kOcclusion), slot);
}

TEST(Compose, LayersGoOverThePreset) {
  SceneSpec spec = sphere_of("car");
  spec.materials["car"].preset = "paint-red";
  spec.materials["car"].clearcoat_perceptual_roughness = 0.5f;
  spec.materials["car"].attenuation_color = glm::vec3(0, 0.5f, 1);
  const Material material = compose_scene(spec, nullptr).scene.materials[0];
  EXPECT_EQ(material.name, "car");
  EXPECT_EQ(material.clearcoat, 1);
  EXPECT_EQ(material.clearcoat_perceptual_roughness, 0.5f);
  EXPECT_EQ(material.attenuation_color, glm::vec3(kLeastAttenuation, 0.5f, 1));
}

TEST(Compose, AShadingModelIsOfAllThatStateNone) {
  const Scene scene = model();
  SceneSpec spec = sphere_of("own");
  spec.nodes.push_back(NodeSpec{.mesh = "shader-ball", .material = "gold"});
  spec.shading_model = ShadingModel::kPhong;
  spec.materials["own"].model = ShadingModel::kSchlickBeckmann;
  spec.materials["skin"].preset = "gold";
  const ComposedScene composed = compose_scene(spec, &scene);
  ASSERT_GE(composed.scene.materials.size(), 5u);
  for (const Material& material : composed.scene.materials)
    EXPECT_EQ(material.model, material.name == "own" ? ShadingModel::kSchlickBeckmann : ShadingModel::kPhong)
        << material.name;
}

TEST(Compose, MetallicOrRoughnessEndSpecularGlossiness) {
  Scene scene = model();
  Material& archived = scene.materials[0];
  archived.specular_glossiness = true;
  archived.metallic = 0;
  archived.perceptual_roughness = 0.3f;
  SceneSpec spec;
  spec.materials["skin"].base_color = glm::vec4(0.5f);
  EXPECT_TRUE(compose_scene(spec, &scene).scene.materials[0].specular_glossiness);
  spec.materials["skin"].metallic = 1;
  const Material material = compose_scene(spec, &scene).scene.materials[0];
  EXPECT_FALSE(material.specular_glossiness);
  EXPECT_EQ(material.perceptual_roughness, 0.3f);
  EXPECT_FALSE(material.texture(TextureUse::kMetallicRoughness));
  EXPECT_TRUE(material.texture(TextureUse::kBaseColor));

  SceneSpec textured;
  texture(textured, "skin", TextureUse::kMetallicRoughness) = file("mr");
  const ComposedScene composed = compose_scene(textured, &scene);
  EXPECT_FALSE(composed.scene.materials[0].specular_glossiness);
  EXPECT_EQ(composed.scene.materials[0].texture(TextureUse::kMetallicRoughness)->image, 1);
}

TEST(Compose, MeshesGetWhatAnOverrideNeedsUnderAnotherKey) {
  Scene scene = model();
  scene.materials[0].textures = {};
  const ComposedScene plain = compose_scene({}, &scene);
  EXPECT_THAT(plain.scene.meshes[0]->tangents, IsEmpty());

  SceneSpec brushed;
  brushed.materials["skin"].anisotropy = 0.5f;
  const ComposedScene composed = compose_scene(brushed, &scene);
  EXPECT_THAT(composed.scene.meshes[0]->tangents, SizeIs(3));
  EXPECT_THAT(composed.scene.meshes[0]->uvs[0], Each(glm::vec2(0)));
  EXPECT_NE(composed.scene.meshes[0]->key, plain.scene.meshes[0]->key);
  ASSERT_NE(find_note(composed, "tangents-generated"), nullptr);
  EXPECT_EQ(find_note(composed, "tangents-generated")->pointer, "/scene/materials/skin");
  EXPECT_NE(find_note(composed, "uv-set-missing"), nullptr);

  SceneSpec second_set;
  TextureFile occlusion = file("o");
  occlusion.uv_set = 1;
  texture(second_set, "skin", TextureUse::kOcclusion) = occlusion;
  const ComposedScene other = compose_scene(second_set, &scene);
  EXPECT_THAT(other.scene.meshes[0]->tangents, IsEmpty());
  EXPECT_THAT(other.scene.meshes[0]->uvs[1], SizeIs(3));
  EXPECT_NE(other.scene.meshes[0]->key, plain.scene.meshes[0]->key);
  EXPECT_NE(other.scene.meshes[0]->key, composed.scene.meshes[0]->key);
}

TEST(Compose, BuiltInMeshesHaveWhatTexturesNeed) {
  SceneSpec spec;
  for (const char* mesh : {"sphere", "cube", "plane", "cylinder", "torus", "shader-ball"})
    spec.nodes.push_back(NodeSpec{.mesh = mesh, .material = "m"});
  texture(spec, "m", TextureUse::kNormal) = file("n");
  spec.materials["m"].anisotropy = 1;
  const ComposedScene composed = compose_scene(spec, nullptr);
  EXPECT_THAT(composed.scene.notes, IsEmpty());
  for (const SharedMesh& mesh : composed.scene.meshes) {
    EXPECT_EQ(mesh->tangents.size(), mesh->positions.size()) << mesh->name;
    EXPECT_EQ(mesh->uvs[0].size(), mesh->positions.size()) << mesh->name;
  }
}

TEST(Compose, AVariantThatIsNotThereIsRefused) {
  const Scene scene = model();
  SceneSpec spec;
  spec.variant = "night";
  EXPECT_NO_THROW(compose_scene(spec, &scene));
  spec.variant = "dusk";
  try {
    compose_scene(spec, &scene);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    EXPECT_EQ(error.pointer, "/scene/variant");
    EXPECT_NE(error.message.find("\"day\", \"night\""), std::string::npos) << error.message;
  }
}

TEST(Compose, MaterialsThatNothingWearsAreNoted) {
  SceneSpec spec = sphere_of("gold");
  spec.materials["a~b"].metallic = 1;
  const ComposedScene composed = compose_scene(spec, nullptr);
  ASSERT_NE(find_note(composed, "material-unused"), nullptr);
  EXPECT_EQ(find_note(composed, "material-unused")->pointer, "/scene/materials/a~0b");
}

}  // namespace
}  // namespace furnace
