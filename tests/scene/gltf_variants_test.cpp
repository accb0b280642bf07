// KHR_materials_variants.
#include <gmock/gmock.h>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A triangle that is "red", and "blue" in the variants "night" and "sea".
GltfBuilder painted() {
  GltfBuilder builder = clean_builder();
  const int red = builder.add("materials", {{"name", "red"}});
  const int blue = builder.add("materials", {{"name", "blue"}});
  for (const char* name : {"day", "night", "sea"})
    builder.json["extensions"]["KHR_materials_variants"]["variants"].push_back({{"name", name}});
  primitive_of(builder)["material"] = red;
  primitive_of(builder)["extensions"]["KHR_materials_variants"]["mappings"] = {
      {{"material", blue}, {"variants", {1, 2}}}};
  return builder;
}

std::string material_in(const GltfBuilder& builder, std::optional<std::string> variant) {
  const Scene scene = builder.import({.variant = std::move(variant)});
  return scene.materials.at(std::size_t(scene.instances.at(0).material)).name;
}

TEST(GltfVariants, AreNamedAndChosen) {
  const GltfBuilder builder = painted();
  EXPECT_THAT(builder.import().variants, ElementsAre("day", "night", "sea"));
  EXPECT_EQ(material_in(builder, std::nullopt), "red");
  EXPECT_EQ(material_in(builder, "day"), "red");  // maps nothing
  EXPECT_EQ(material_in(builder, "night"), "blue");
  EXPECT_EQ(material_in(builder, "sea"), "blue");
  EXPECT_EQ(material_in(builder, "unknown"), "red");
  EXPECT_THAT(builder.import({.variant = "night"}).notes, IsEmpty());
  EXPECT_THAT(clean_builder().import().variants, IsEmpty());
}

TEST(GltfVariants, MakeScenesOfTheirOwn) {
  const GltfBuilder builder = painted();
  EXPECT_NE(builder.import().hash, builder.import({.variant = "day"}).hash);
  EXPECT_NE(builder.import({.variant = "night"}).hash, builder.import({.variant = "day"}).hash);
  EXPECT_EQ(builder.import().hash, builder.import({.variant = "unknown"}).hash);
}

TEST(GltfVariants, BringTheMeshWhatTheyNeed) {
  GltfBuilder builder = painted();
  builder.json["materials"][1]["extensions"]["KHR_materials_anisotropy"]["anisotropyStrength"] = 1;
  EXPECT_THAT(builder.import().meshes[0]->tangents, IsEmpty());
  EXPECT_THAT(builder.import({.variant = "sea"}).meshes[0]->tangents, ::testing::SizeIs(3));
}

TEST(GltfVariants, WrongMappingsAreRefusedAtTheirPlace) {
  const std::string place = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0/";
  GltfBuilder builder = painted();
  Json& mapping = primitive_of(builder)["extensions"]["KHR_materials_variants"]["mappings"][0];
  mapping["variants"] = {1, 3};
  EXPECT_EQ(pointer_of_error(builder), place + "variants/1");
  mapping["variants"] = {1};
  mapping["material"] = 2;
  EXPECT_EQ(pointer_of_error(builder), place + "material");
  mapping.erase("material");
  EXPECT_EQ(pointer_of_error(builder), place + "material");

  GltfBuilder nameless = painted();
  nameless.json["extensions"]["KHR_materials_variants"]["variants"][2].erase("name");
  EXPECT_EQ(pointer_of_error(nameless), "/extensions/KHR_materials_variants/variants/2/name");
}

}  // namespace
}  // namespace furnace::testing
