#include "renderer/scene/material.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

namespace furnace {
namespace {

TEST(DefaultMaterial, HasTheDefaultsOfGltf) {
  const Material material = default_material();
  EXPECT_EQ(material.base_color, glm::vec4(1));
  EXPECT_EQ(material.metallic, 1);
  EXPECT_EQ(material.perceptual_roughness, 1);
  EXPECT_EQ(material.emissive, glm::vec3(0));
  EXPECT_EQ(material.emissive_strength, 1);
  EXPECT_EQ(material.alpha_mode, AlphaMode::kOpaque);
  EXPECT_EQ(material.alpha_cutoff, 0.5f);
  EXPECT_FALSE(material.double_sided);
  EXPECT_FALSE(material.texture(TextureUse::kBaseColor).has_value());
}

TEST(MaterialPreset, EveryNameIsKebabCaseUniqueAndGivesAMaterialOfThatName) {
  std::set<std::string_view> seen;
  for (const std::string_view name : material_preset_names()) {
    EXPECT_THAT(std::string(name), testing::MatchesRegex("[a-z]+(-[a-z]+)*"));
    EXPECT_TRUE(seen.insert(name).second) << name;
    const auto material = material_preset(name);
    ASSERT_TRUE(material.has_value()) << name;
    EXPECT_EQ(material->name, name);
  }
  EXPECT_GE(seen.size(), 25u);
}

TEST(MaterialPreset, ValuesArePhysical) {
  for (const std::string_view name : material_preset_names()) {
    const Material material = *material_preset(name);
    SCOPED_TRACE(material.name);
    for (int i = 0; i < 3; ++i) {
      EXPECT_GT(material.base_color[i], 0.005f);
      // A diffuse surface that returns more than chalk does would look as if it glowed.
      const bool diffuse = material.metallic == 0 && material.transmission == 0;
      EXPECT_LE(material.base_color[i], diffuse ? 0.9f : 1.0f);
    }
    EXPECT_EQ(material.base_color.a, 1);
    EXPECT_GE(material.metallic, 0);
    EXPECT_LE(material.metallic, 1);
    EXPECT_GE(material.perceptual_roughness, 0);
    EXPECT_LE(material.perceptual_roughness, 1);
  }
}

TEST(MaterialPreset, ContractNamesExist) {
  for (const char* name :
       {"gold",         "silver",        "copper",    "aluminum", "aluminium",    "iron",       "chrome",
        "titanium",     "nickel",        "platinum",  "brass",    "gold-brushed", "gold-rough", "plastic-red",
        "rubber-black", "ceramic-white", "porcelain", "clay",     "chalk",        "wood-oak",   "paint-red"})
    EXPECT_TRUE(material_preset(name).has_value()) << name;
}

TEST(MaterialPreset, SomeHaveLayers) {
  for (const std::string_view name : material_preset_names()) {
    const Material material = *material_preset(name);
    SCOPED_TRACE(material.name);
    EXPECT_EQ(material.anisotropy > 0, name.ends_with("-brushed") || name.starts_with("satin-"));
    EXPECT_TRUE(!name.starts_with("paint-") || material.clearcoat == 1);
    EXPECT_EQ(name.starts_with("velvet-"), material.sheen_color != glm::vec3(0) && material.anisotropy == 0);
    EXPECT_TRUE(!name.starts_with("glass") || material.transmission == 1);
    EXPECT_TRUE(material.ior >= 1);
  }
  EXPECT_EQ(material_preset("glass-pane")->thickness_m, 0);
  EXPECT_GT(material_preset("diamond")->dispersion, 0);
  EXPECT_EQ(material_preset("soap-bubble")->iridescence, 1);
  EXPECT_GT(material_preset("leaf")->diffuse_transmission, 0);
}

TEST(TextureUse, NamesDifferAndColorsAreKnown) {
  std::set<std::string_view> names;
  int colors = 0;
  for (std::size_t use = 0; use < kTextureUses; ++use) {
    const std::string_view name = texture_use_name(TextureUse(use));
    EXPECT_TRUE(names.insert(name).second) << name;
    const bool color = is_color_texture({}, TextureUse(use));
    EXPECT_EQ(color, name.ends_with("Color") || name == "emissive") << name;
    colors += color;
  }
  EXPECT_EQ(colors, 5);
  Material archived;
  archived.specular_glossiness = true;
  EXPECT_TRUE(is_color_texture(archived, TextureUse::kMetallicRoughness));
}

TEST(MaterialPreset, SpellingsOfAluminumAreOneMaterial) {
  EXPECT_EQ(material_preset("aluminum")->base_color, material_preset("aluminium")->base_color);
}

TEST(MaterialPreset, UnknownNamesGiveNothing) {
  EXPECT_FALSE(material_preset("unobtainium").has_value());
  EXPECT_FALSE(material_preset("").has_value());
  EXPECT_FALSE(material_preset("Gold").has_value());
}

}  // namespace
}  // namespace furnace
