// The material extensions: every member is read, ranges are kept, tangents come where they are needed.
#include <gmock/gmock.h>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

GltfBuilder with_extensions(Json extensions, Json material = Json::object()) {
  GltfBuilder builder = clean_builder();
  add_texture(builder, "a.png");
  material["extensions"] = std::move(extensions);
  primitive_of(builder)["material"] = builder.add("materials", std::move(material));
  return builder;
}

Scene import_extension(const std::string& name, Json members) {
  return import_with_png(with_extensions({{name, std::move(members)}}), "a.png");
}

const Json kTexture = {{"index", 0}};

// One member of one extension, set, with what it must become.
struct Member {
  const char* extension;
  const char* key;
  Json value;
  float (*read)(const Material&);
  float expected;
};

const std::vector<Member> kMembers = {
    {"ior", "ior", 1.33, [](const Material& m) { return m.ior; }, 1.33f},
    {"ior", "ior", 0, [](const Material& m) { return m.ior; }, 0},
    {"specular", "specularFactor", 0.25, [](const Material& m) { return m.specular; }, 0.25f},
    {"specular",
     "specularColorFactor",
     {1, 2.5, 1},
     [](const Material& m) { return m.specular_color.g; },
     2.5f},
    {"clearcoat", "clearcoatFactor", 0.25, [](const Material& m) { return m.clearcoat; }, 0.25f},
    {"clearcoat", "clearcoatRoughnessFactor", 0.25,
     [](const Material& m) { return m.clearcoat_perceptual_roughness; }, 0.25f},
    {"clearcoat",
     "clearcoatNormalTexture",
     {{"index", 0}, {"scale", 0.25}},
     [](const Material& m) { return m.clearcoat_normal_scale; },
     0.25f},
    {"sheen", "sheenColorFactor", {1, 0.25, 1}, [](const Material& m) { return m.sheen_color.g; }, 0.25f},
    {"sheen", "sheenRoughnessFactor", 0.25, [](const Material& m) { return m.sheen_perceptual_roughness; },
     0.25f},
    {"anisotropy", "anisotropyStrength", 0.25, [](const Material& m) { return m.anisotropy; }, 0.25f},
    {"anisotropy", "anisotropyRotation", -7, [](const Material& m) { return m.anisotropy_rotation_rad; }, -7},
    {"iridescence", "iridescenceFactor", 0.25, [](const Material& m) { return m.iridescence; }, 0.25f},
    {"iridescence", "iridescenceIor", 1.75, [](const Material& m) { return m.iridescence_ior; }, 1.75f},
    {"iridescence", "iridescenceThicknessMinimum", 200,
     [](const Material& m) { return m.iridescence_thickness_min_nm; }, 200},
    {"iridescence", "iridescenceThicknessMaximum", 50,
     [](const Material& m) { return m.iridescence_thickness_max_nm; }, 50},
    {"transmission", "transmissionFactor", 0.25, [](const Material& m) { return m.transmission; }, 0.25f},
    {"volume", "thicknessFactor", 25, [](const Material& m) { return m.thickness_m; }, 25},
    {"volume", "attenuationDistance", 25, [](const Material& m) { return m.attenuation_distance_m; }, 25},
    {"volume",
     "attenuationColor",
     {1, 0.25, 1},
     [](const Material& m) { return m.attenuation_color.g; },
     0.25f},
    {"dispersion", "dispersion", 2.5, [](const Material& m) { return m.dispersion; }, 2.5f},
    {"diffuse_transmission", "diffuseTransmissionFactor", 0.25,
     [](const Material& m) { return m.diffuse_transmission; }, 0.25f},
    {"diffuse_transmission",
     "diffuseTransmissionColorFactor",
     {1, 0.25, 1},
     [](const Material& m) { return m.diffuse_transmission_color.g; },
     0.25f},
    {"pbrSpecularGlossiness",
     "diffuseFactor",
     {1, 1, 1, 0.25},
     [](const Material& m) { return m.base_color.a; },
     0.25f},
    {"pbrSpecularGlossiness",
     "specularFactor",
     {1, 0.25, 1},
     [](const Material& m) { return m.glossy_specular.g; },
     0.25f},
    {"pbrSpecularGlossiness", "glossinessFactor", 0.25, [](const Material& m) { return m.glossiness; },
     0.25f},
};

TEST(GltfLayers, EachMemberIsReadAndHasItsDefault) {
  const Material defaults;
  for (const Member& member : kMembers) {
    SCOPED_TRACE(member.key);
    const std::string name = std::string("KHR_materials_") + member.extension;
    const Scene set = import_extension(name, {{member.key, member.value}});
    EXPECT_EQ(member.read(set.materials.at(0)), member.expected);
    EXPECT_EQ(find_note(set, "value-clamped"), nullptr);
    const Scene unset = import_extension(name, Json::object());
    EXPECT_EQ(member.read(unset.materials.at(0)), member.read(defaults));
  }
}

struct Slot {
  const char* extension;
  const char* key;
  TextureUse use;
};

constexpr Slot kSlots[] = {
    {"specular", "specularTexture", TextureUse::kSpecular},
    {"specular", "specularColorTexture", TextureUse::kSpecularColor},
    {"clearcoat", "clearcoatTexture", TextureUse::kClearcoat},
    {"clearcoat", "clearcoatRoughnessTexture", TextureUse::kClearcoatRoughness},
    {"clearcoat", "clearcoatNormalTexture", TextureUse::kClearcoatNormal},
    {"sheen", "sheenColorTexture", TextureUse::kSheenColor},
    {"sheen", "sheenRoughnessTexture", TextureUse::kSheenRoughness},
    {"anisotropy", "anisotropyTexture", TextureUse::kAnisotropy},
    {"iridescence", "iridescenceTexture", TextureUse::kIridescence},
    {"iridescence", "iridescenceThicknessTexture", TextureUse::kIridescenceThickness},
    {"transmission", "transmissionTexture", TextureUse::kTransmission},
    {"volume", "thicknessTexture", TextureUse::kThickness},
    {"diffuse_transmission", "diffuseTransmissionTexture", TextureUse::kDiffuseTransmission},
    {"diffuse_transmission", "diffuseTransmissionColorTexture", TextureUse::kDiffuseTransmissionColor},
    {"pbrSpecularGlossiness", "diffuseTexture", TextureUse::kBaseColor},
    {"pbrSpecularGlossiness", "specularGlossinessTexture", TextureUse::kMetallicRoughness},
};

TEST(GltfLayers, EachTextureFindsItsSlotWithItsTransform) {
  const Json texture = {
      {"index", 0}, {"texCoord", 1}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0}}}}}}};
  for (const Slot& slot : kSlots) {
    SCOPED_TRACE(slot.key);
    const Scene scene =
        import_extension(std::string("KHR_materials_") + slot.extension, {{slot.key, texture}});
    for (std::size_t use = 0; use < kTextureUses; ++use)
      EXPECT_EQ(scene.materials[0].textures[use].has_value(), TextureUse(use) == slot.use);
    ASSERT_TRUE(scene.materials[0].texture(slot.use));
    EXPECT_EQ(scene.materials[0].texture(slot.use)->uv_set, 1);
    EXPECT_EQ(scene.materials[0].texture(slot.use)->transform.offset, glm::vec2(0.5f, 0));
  }
}

TEST(GltfLayers, ValuesOutOfRangeAreBroughtBackAndNoted) {
  const std::vector<Member> rows = {
      {"ior", "ior", 0.5, [](const Material& m) { return m.ior; }, 1},
      {"ior", "ior", -1, [](const Material& m) { return m.ior; }, 1},
      {"specular",
       "specularColorFactor",
       {-1, 1, 1},
       [](const Material& m) { return m.specular_color.r; },
       0},
      {"sheen", "sheenColorFactor", {2, 0, 0}, [](const Material& m) { return m.sheen_color.r; }, 1},
      {"iridescence", "iridescenceThicknessMinimum", -5,
       [](const Material& m) { return m.iridescence_thickness_min_nm; }, 0},
      {"iridescence", "iridescenceIor", 0.5, [](const Material& m) { return m.iridescence_ior; }, 1},
      {"volume", "attenuationDistance", 0, [](const Material& m) { return m.attenuation_distance_m; }, 1e-6f},
      {"volume", "thicknessFactor", -1, [](const Material& m) { return m.thickness_m; }, 0},
      {"dispersion", "dispersion", -1, [](const Material& m) { return m.dispersion; }, 0},
  };
  for (const Member& row : rows) {
    SCOPED_TRACE(row.key);
    const std::string name = std::string("KHR_materials_") + row.extension;
    const Scene scene = import_extension(name, {{row.key, row.value}});
    EXPECT_EQ(row.read(scene.materials[0]), row.expected);
    ASSERT_NE(find_note(scene, "value-clamped"), nullptr);
    EXPECT_EQ(find_note(scene, "value-clamped")->pointer, "/materials/0/extensions/" + name + "/" + row.key);
  }
}

TEST(GltfLayers, AnAbsentDistanceIsInfiniteAndBlackHasALogarithm) {
  const Scene scene = import_extension("KHR_materials_volume", {{"attenuationColor", {0, 0.5, 1}}});
  EXPECT_EQ(scene.materials[0].attenuation_distance_m, kInfinity);
  EXPECT_EQ(scene.materials[0].attenuation_color, glm::vec3(kLeastAttenuation, 0.5f, 1));
  EXPECT_THAT(scene.notes, IsEmpty());
}

TEST(GltfLayers, WrongTypesAreRefusedAtTheirPlace) {
  EXPECT_EQ(pointer_of_error(with_extensions({{"KHR_materials_sheen", {{"sheenColorFactor", {1, 2}}}}})),
            "/materials/0/extensions/KHR_materials_sheen/sheenColorFactor");
  EXPECT_EQ(pointer_of_error(with_extensions({{"KHR_materials_ior", {{"ior", "1.5"}}}})),
            "/materials/0/extensions/KHR_materials_ior/ior");
  EXPECT_EQ(pointer_of_error(
                with_extensions({{"KHR_materials_clearcoat", {{"clearcoatTexture", {{"index", 9}}}}}})),
            "/materials/0/extensions/KHR_materials_clearcoat/clearcoatTexture/index");
}

// A file brings metallic-roughness for readers that do not know the archived extension.
TEST(GltfLayers, SpecularGlossinessTakesThePlaceOfMetallicRoughness) {
  const Json fallback = {{"pbrMetallicRoughness",
                          {{"baseColorFactor", {1, 0, 0, 1}},
                           {"baseColorTexture", kTexture},
                           {"metallicRoughnessTexture", kTexture}}}};
  const GltfBuilder builder =
      with_extensions({{"KHR_materials_pbrSpecularGlossiness",
                        {{"diffuseFactor", {0, 1, 0, 1}}, {"glossinessFactor", 0.75}}}},
                      fallback);
  const Material material = import_with_png(builder, "a.png").materials.at(0);
  EXPECT_TRUE(material.specular_glossiness);
  EXPECT_EQ(material.base_color, glm::vec4(0, 1, 0, 1));
  EXPECT_EQ(material.glossiness, 0.75f);
  EXPECT_EQ(material.perceptual_roughness, 0.25f);
  EXPECT_EQ(material.metallic, 0);
  EXPECT_FALSE(material.texture(TextureUse::kBaseColor));
  EXPECT_FALSE(material.texture(TextureUse::kMetallicRoughness));
}

TEST(GltfLayers, TangentsComeForClearcoatNormalsAndAnisotropy) {
  GltfBuilder coated = with_extensions(
      {{"KHR_materials_clearcoat", {{"clearcoatNormalTexture", {{"index", 0}, {"texCoord", 1}}}}}});
  // Here u grows along y.
  primitive_of(coated)["attributes"]["TEXCOORD_1"] = coated.add_accessor<float>("VEC2", {0, 0, 0, 1, 1, 0});
  const Scene coat = import_with_png(coated, "a.png");
  EXPECT_THAT(note_codes(coat), ElementsAre("tangents-generated"));
  for (const glm::vec4& tangent : coat.meshes[0]->tangents) EXPECT_EQ(glm::vec3(tangent), glm::vec3(0, 1, 0));
  const Scene brushed = import_extension("KHR_materials_anisotropy", {{"anisotropyStrength", 1}});
  EXPECT_THAT(note_codes(brushed), ElementsAre("tangents-generated"));
  EXPECT_THAT(brushed.meshes[0]->tangents, ::testing::Each(glm::vec4(1, 0, 0, -1)));
  const Scene isotropic = import_extension("KHR_materials_anisotropy",
                                           {{"anisotropyStrength", 0}, {"anisotropyTexture", kTexture}});
  EXPECT_THAT(isotropic.meshes[0]->tangents, IsEmpty());

  GltfBuilder bare = with_extensions({{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}});
  primitive_of(bare)["attributes"].erase("TEXCOORD_0");
  const Scene scene = import_with_png(bare, "a.png");
  EXPECT_THAT(note_codes(scene), ElementsAre("uv-set-missing", "tangents-generated"));
  for (const glm::vec4& tangent : scene.meshes[0]->tangents)
    EXPECT_NEAR(glm::length(glm::vec3(tangent)), 1, 1e-6f);
}

}  // namespace
}  // namespace furnace::testing
