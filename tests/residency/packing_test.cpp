// Material and instance -> GPU blocks: every field arrives where the shader reads it.
#include <cmath>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/residency/gpu_blocks.hpp"

namespace furnace::gpu {
namespace {

TEST(Packing, EveryMaterialNumberHasItsPlace) {
  Material material;
  material.base_color = {0.1f, 0.2f, 0.3f, 0.4f};
  material.metallic = 0.5f;
  material.perceptual_roughness = 0.6f;
  material.emissive = {1, 2, 3};
  material.emissive_strength = 4;
  material.normal_scale = 0.7f;
  material.occlusion_strength = 0.8f;
  material.alpha_mode = AlphaMode::kBlend;
  material.alpha_cutoff = 0.9f;
  material.double_sided = true;
  const MaterialBlock block = pack_material(material);
  EXPECT_EQ(block.base_color, material.base_color);
  EXPECT_EQ(block.emissive, vec4(4, 8, 12, 0));
  EXPECT_EQ(block.metallic, 0.5f);
  EXPECT_EQ(block.perceptual_roughness, 0.6f);
  EXPECT_EQ(block.normal_scale, 0.7f);
  EXPECT_EQ(block.occlusion_strength, 0.8f);
  EXPECT_EQ(block.alpha_cutoff, 0.9f);
  EXPECT_EQ(block.double_sided, 1u);
  EXPECT_EQ(block.uv_sets, 0u);
}

TEST(Packing, OpaqueMaterialsHaveNoAlpha) {
  Material material;
  material.base_color.a = 0.25f;
  EXPECT_EQ(pack_material(material).base_color.a, 1);
}

unsigned bit_of(TextureUse use) {
  return 1u << unsigned(use);
}

TEST(Packing, UvSetsAreBitsBySlot) {
  Material material;
  material.texture(TextureUse::kNormal) = TextureSlot{};
  material.texture(TextureUse::kNormal)->uv_set = 1;
  material.texture(TextureUse::kEmissive) = TextureSlot{};
  material.texture(TextureUse::kEmissive)->uv_set = 1;
  material.texture(TextureUse::kBaseColor) = TextureSlot{};
  EXPECT_EQ(pack_material(material).uv_sets, bit_of(TextureUse::kNormal) | bit_of(TextureUse::kEmissive));
}

glm::vec2 transformed(const UvTransform& transform, glm::vec2 uv) {
  Material material;
  material.texture(TextureUse::kOcclusion) = TextureSlot{};
  material.texture(TextureUse::kOcclusion)->transform = transform;
  const MaterialBlock block = pack_material(material);
  const glm::vec3 homogeneous(uv, 1);
  constexpr auto kRow = 2 * std::size_t(TextureUse::kOcclusion);
  return {glm::dot(glm::vec3(block.uv_rows[kRow]), homogeneous),
          glm::dot(glm::vec3(block.uv_rows[kRow + 1]), homogeneous)};
}

TEST(Packing, LayersOfAPlainMaterialChangeNothing) {
  const LayerBlock block = pack_layers(Material{});
  EXPECT_FLOAT_EQ(block.specular.r, 0.04f);
  EXPECT_EQ(block.specular.w, 1);
  EXPECT_EQ(block.clearcoat.x, 0);
  EXPECT_EQ(block.transmission.x, 0);
  EXPECT_EQ(glm::vec3(block.absorption), glm::vec3(0));
  EXPECT_EQ(pack_material(Material{}).shadow_opacity, 1);
}

TEST(Packing, AbsorptionLeavesTheAttenuationColourAfterItsDistance) {
  Material material;
  material.attenuation_distance_m = 0.5f;
  material.attenuation_color = {0.25f, 1, 0};
  const LayerBlock block = pack_layers(material);
  EXPECT_NEAR(std::exp(-block.absorption.r * 0.5f), 0.25, 1e-6);
  EXPECT_EQ(block.absorption.g, 0);
  EXPECT_TRUE(std::isfinite(block.absorption.b));
}

TEST(Packing, LayersReadTheirOwnUvSets) {
  Material material;
  material.texture(TextureUse::kSheenColor) = TextureSlot{};
  material.texture(TextureUse::kSheenColor)->uv_set = 1;
  material.texture(TextureUse::kNormal) = material.texture(TextureUse::kSheenColor);
  EXPECT_EQ(pack_layers(material).uv_sets << kCoreTextures, bit_of(TextureUse::kSheenColor));
}

TEST(Packing, AnIorOfZeroReflectsEverything) {
  Material material;
  material.ior = 0;
  EXPECT_EQ(pack_layers(material).specular.r, 1);
}

TEST(Packing, GlassKeepsLittleOfTheLight) {
  Material material;
  material.metallic = 0;
  material.transmission = 1;
  EXPECT_NEAR(pack_material(material).shadow_opacity, 0.08, 1e-6);
  material.texture(TextureUse::kTransmission) = TextureSlot{};
  EXPECT_EQ(pack_material(material).shadow_opacity, 1);
}

TEST(Packing, UvTransformScalesThenRotatesThenMoves) {
  UvTransform transform;
  EXPECT_EQ(transformed(transform, {0.25f, 0.75f}), glm::vec2(0.25f, 0.75f));
  transform.scale = {2, 3};
  transform.offset = {0.5f, -0.5f};
  EXPECT_EQ(transformed(transform, {1, 1}), glm::vec2(2.5f, 2.5f));
  // KHR_texture_transform: counter-clockwise in a UV space whose V points down, so +U turns to -V.
  UvTransform quarter;
  quarter.rotation_rad = 1.57079632679f;
  const glm::vec2 turned = transformed(quarter, {1, 0});
  EXPECT_NEAR(turned.x, 0, 1e-6);
  EXPECT_NEAR(turned.y, -1, 1e-6);
}

TEST(Packing, NormalsStayPerpendicularUnderAnyScale) {
  const glm::mat4 world_from_model =
      glm::scale(glm::rotate(glm::mat4(1), 0.7f, glm::vec3(1, 2, 3)), {2, 0.5f, -3});
  const DrawBlock block = pack_draw(world_from_model, 7, 4);
  EXPECT_EQ(block.handedness, -1);
  const glm::vec3 normal(0.6f, 0.8f, 0), tangent(-0.8f, 0.6f, 0), bitangent(0, 0, 1);
  const glm::vec3 n = glm::mat3(block.world_from_model_normal) * normal;
  EXPECT_NEAR(glm::dot(n, glm::mat3(world_from_model) * tangent), 0, 1e-5);
  EXPECT_NEAR(glm::dot(n, glm::mat3(world_from_model) * bitangent), 0, 1e-5);
  // Outwards stays outwards: the normal and its moved point lie on one side.
  EXPECT_GT(glm::dot(n, glm::mat3(world_from_model) * normal), 0);
}

// Of models from the size of an atom to that of a planet's orbit, and without a change of any digit.
TEST(Packing, NormalsDoNotGrowWithTheModel) {
  const glm::mat4 turned = glm::scale(glm::rotate(glm::mat4(1), 0.7f, glm::vec3(1, 2, 3)), {2, 0.5f, -3});
  const DrawBlock plain = pack_draw(turned, 7, 4);
  for (const int exponent : {-60, -40, 40, 60}) {
    const DrawBlock block = pack_draw(glm::scale(turned, glm::vec3(std::ldexp(1.f, exponent))), 7, 4);
    EXPECT_EQ(block.world_from_model_normal, plain.world_from_model_normal) << exponent;
    EXPECT_EQ(block.handedness, -1) << exponent;
  }
}

}  // namespace
}  // namespace furnace::gpu
