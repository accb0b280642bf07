#include <gmock/gmock.h>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(GltfMaterial, MaterialsAreReadFieldByField) {
  GltfBuilder builder = clean_builder();
  const int texture = add_texture(builder, "a.png");
  builder.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9985}}};
  builder.json["textures"][0]["sampler"] = 0;
  const Json ref = {{"index", texture}, {"texCoord", 1}};
  primitive_of(builder)["material"] = builder.add(
      "materials",
      {{"name", "paint"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}},
         {"metallicFactor", 0.5},
         {"roughnessFactor", 0.6},
         {"baseColorTexture",
          {{"index", texture},
           {"extensions",
            {{"KHR_texture_transform",
              {{"offset", {0.1, 0.2}}, {"rotation", 0.3}, {"scale", {4, 5}}, {"texCoord", 1}}}}}}},
         {"metallicRoughnessTexture", ref}}},
       {"occlusionTexture", {{"index", texture}, {"strength", 0.7}}},
       {"emissiveTexture", ref},
       {"emissiveFactor", {0.8, 0.9, 1}},
       {"alphaMode", "MASK"},
       {"alphaCutoff", 0.25},
       {"doubleSided", true},
       {"extensions",
        {{"KHR_materials_emissive_strength", {{"emissiveStrength", 11}}},
         {"KHR_materials_unlit", Json::object()}}}});
  const Scene scene = import_with_png(builder, "a.png");
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.name, "paint");
  EXPECT_EQ(material.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(material.metallic, 0.5f);
  EXPECT_EQ(material.perceptual_roughness, 0.6f);
  EXPECT_EQ(material.emissive, glm::vec3(0.8f, 0.9f, 1));
  EXPECT_EQ(material.emissive_strength, 11);
  EXPECT_EQ(material.occlusion_strength, 0.7f);
  EXPECT_EQ(material.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_TRUE(material.unlit);
  ASSERT_TRUE(material.texture(TextureUse::kBaseColor));
  EXPECT_EQ(material.texture(TextureUse::kBaseColor)->uv_set, 1);  // KHR_texture_transform's own
  EXPECT_EQ(material.texture(TextureUse::kBaseColor)->transform, (UvTransform{{0.1f, 0.2f}, 0.3f, {4, 5}}));
  EXPECT_EQ(material.texture(TextureUse::kBaseColor)->sampler,
            (SamplerDesc{Wrap::kClampToEdge, Wrap::kMirroredRepeat, Filter::kNearest, Filter::kLinear,
                         MipFilter::kNearest}));
  EXPECT_EQ(material.texture(TextureUse::kMetallicRoughness)->uv_set, 1);
  EXPECT_EQ(material.texture(TextureUse::kOcclusion)->uv_set, 0);
  EXPECT_TRUE(material.texture(TextureUse::kEmissive));
  EXPECT_FALSE(material.texture(TextureUse::kNormal));
  ASSERT_EQ(scene.images.size(), 1u);  // one image, four slots
  EXPECT_EQ(scene.images[0].pointer, "/images/0");
  EXPECT_EQ(scene.images[0].encoded.text(), kPngStart);
}

TEST(GltfMaterial, FactorsOutOfRangeAreClampedAndNoted) {
  GltfBuilder builder = clean_builder();
  primitive_of(builder)["material"] = builder.add(
      "materials", {{"pbrMetallicRoughness", {{"roughnessFactor", 1.5}}}, {"emissiveFactor", {2, -1, 0}}});
  const Scene scene = builder.import();
  EXPECT_EQ(scene.materials[0].perceptual_roughness, 1);
  EXPECT_EQ(scene.materials[0].emissive, glm::vec3(1, 0, 0));
  EXPECT_THAT(note_codes(scene), ElementsAre("value-clamped", "value-clamped"));
  EXPECT_EQ(scene.notes[0].pointer, "/materials/0/pbrMetallicRoughness/roughnessFactor");
}

TEST(GltfMaterial, OnlyDrawnMaterialsAndTheirImagesCome) {
  GltfBuilder builder = clean_builder();
  builder.add("materials",
              {{"name", "unused"}, {"emissiveTexture", {{"index", add_texture(builder, "lost.png")}}}});
  primitive_of(builder)["material"] = builder.add("materials", {{"name", "used"}});
  const Scene scene = builder.import();
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "used");
  EXPECT_THAT(scene.images, IsEmpty());
  EXPECT_THAT(scene.notes, IsEmpty());
}

TEST(GltfMaterial, TexturesThatCannotBeUsedBecomeNotes) {
  GltfBuilder builder = clean_builder();
  const int missing = add_texture(builder, "lost.png");
  const int unreadable = add_texture(builder, "data.bin");
  const int empty = builder.add("textures", Json::object());
  primitive_of(builder)["material"] =
      builder.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", missing}}}}},
                                {"occlusionTexture", {{"index", unreadable}}},
                                {"emissiveTexture", {{"index", empty}}},
                                {"normalTexture", {{"index", missing}, {"texCoord", 2}}}});
  const Scene scene = builder.import();
  EXPECT_FALSE(scene.materials[0].texture(TextureUse::kBaseColor));
  EXPECT_FALSE(scene.materials[0].texture(TextureUse::kNormal));
  EXPECT_EQ(find_note(scene, "image-missing")->pointer, "/images/0/uri");
  EXPECT_EQ(find_note(scene, "image-unreadable")->pointer, "/images/1");
  EXPECT_EQ(find_note(scene, "texture-without-image")->pointer, "/textures/2");
  EXPECT_EQ(find_note(scene, "uv-set-unsupported")->pointer, "/materials/0/normalTexture");
  EXPECT_EQ(scene.notes.size(), 4u);
}

// An extension's source goes before the plain one, if it can be read.
TEST(GltfMaterial, TexturesHaveSourcesOfExtensions) {
  for (const char* name : {"EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu"}) {
    GltfBuilder builder = clean_builder();
    const int texture = add_texture(builder, "plain.png");
    const int other = builder.add("images", {{"uri", "other.img"}});
    builder.json["textures"][std::size_t(texture)]["extensions"][name]["source"] = other;
    primitive_of(builder)["material"] = builder.add("materials", {{"emissiveTexture", {{"index", texture}}}});
    builder.json["extensionsRequired"] = builder.json["extensionsUsed"] = {name};
    ModelBundle bundle = builder.bundle();
    bundle.siblings["plain.png"] = Blob(kPngStart);
    const auto pointer_of_image = [&](const std::string& bytes) {
      bundle.siblings["other.img"] = Blob(bytes);
      const Scene scene = import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
      EXPECT_EQ(find_note(scene, "image-unreadable") != nullptr, bytes == "?") << name;
      return scene.images.at(std::size_t(scene.materials[0].texture(TextureUse::kEmissive)->image)).pointer;
    };
    EXPECT_EQ(pointer_of_image(kPngStart + "other"), "/images/1") << name;
    EXPECT_EQ(pointer_of_image("?"), "/images/0") << name;

    builder.json["textures"][std::size_t(texture)]["extensions"][name]["source"] = 7;
    EXPECT_EQ(pointer_of_error(builder), "/textures/0/extensions/" + std::string(name) + "/source");
  }
}

TEST(GltfMaterial, NormalMapsGetTangentsAndMissingUvSetsZeros) {
  GltfBuilder builder = clean_builder();
  primitive_of(builder)["material"] = builder.add(
      "materials", {{"normalTexture", {{"index", add_texture(builder, "n.png")}, {"scale", 0.5}}}});
  const Scene scene = import_with_png(builder, "n.png");
  EXPECT_EQ(scene.materials[0].normal_scale, 0.5f);
  EXPECT_THAT(note_codes(scene), ElementsAre("tangents-generated"));
  // u grows along x and v along y, so that "up" in the image is -y.
  EXPECT_THAT(scene.meshes[0]->tangents, ::testing::Each(glm::vec4(1, 0, 0, -1)));

  primitive_of(builder)["attributes"].erase("TEXCOORD_0");
  const Scene bare = import_with_png(builder, "n.png");
  EXPECT_THAT(note_codes(bare), ElementsAre("uv-set-missing", "tangents-generated"));
  EXPECT_THAT(bare.meshes[0]->uvs[0], ::testing::Each(glm::vec2(0)));
  EXPECT_EQ(bare.meshes[0]->tangents.size(), bare.meshes[0]->positions.size());
}

}  // namespace
}  // namespace furnace::testing
