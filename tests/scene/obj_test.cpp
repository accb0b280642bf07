// OBJ and MTL as people write them: what their statements mean, and what is told of those that mean nothing here.
#include <gtest/gtest.h>

#include "renderer/image/encode.hpp"
#include "renderer/scene/mtl_text.hpp"
#include "tests/scene/model_scenes.hpp"

namespace furnace {
namespace {

using namespace test;

constexpr const char* kSquare =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
    "usemtl m\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";

Scene square_of(const std::string& mtl) {
  const std::string png = encode_png(make_image({2, 2}, 3, SampleType::kUint8, ColorSpace::kNonColor), {});
  return import_text(std::string("mtllib m.mtl\n") + kSquare,
                     {{"m.mtl", mtl}, {"a.png", png}, {"b.png", png}});
}

std::vector<std::string> places(const Scene& scene, std::string_view code) {
  std::vector<std::string> found;
  for (const Note& note : scene.notes)
    if (note.code == code) found.push_back(note.pointer);
  return found;
}

TEST(Mtl, OptionsPlaceATexture) {
  const Scene scene = square_of("newmtl m\nmap_Kd -o 0.25 0.5 -s 2 4 1 -clamp on a.png\nmap_Ke b.png\n");
  const Material& material = scene.materials.at(0);
  const TextureSlot& color = material.texture(TextureUse::kBaseColor).value();
  EXPECT_EQ(color.sampler.wrap_u, Wrap::kClampToEdge);
  EXPECT_EQ(color.transform.scale, glm::vec2(2, 4));
  // The lower left corner, (0, 0) in the file and (0, 1) here, shows (0.25, 0.5), which is (0.25, 0.5) here, too.
  EXPECT_EQ(color.transform.offset + color.transform.scale * glm::vec2(0, 1), glm::vec2(0.25f, 0.5f));
  const TextureSlot& emission = material.texture(TextureUse::kEmissive).value();
  EXPECT_EQ(emission.sampler.wrap_u, Wrap::kRepeat);
  EXPECT_EQ(emission.transform.scale, glm::vec2(1));
  EXPECT_EQ(emission.transform.offset, glm::vec2(0));
  EXPECT_TRUE(scene.notes.empty());
}

TEST(Mtl, EveryTextureThatIsLeftOutIsTold) {
  const Scene scene = square_of(
      "newmtl m\nmap_Kd a.png\nmap_Ka a.png\nmap_Ks a.png\nmap_Pr b.png\nrefl -type sphere b.png\n"
      "newmtl other\nmap_Ns a.png\n");
  EXPECT_EQ(places(scene, "texture-ignored"),
            (std::vector<std::string>{"/materials/m/map_Ks", "/materials/m/map_Pr", "/materials/m/refl"}));
  EXPECT_EQ(places(square_of("newmtl m\nmap_Kd a.png\nmap_Ka b.png\n"), "texture-ignored"),
            (std::vector<std::string>{"/materials/m/map_Ka"}));
  EXPECT_EQ(
      places(square_of("newmtl m\nmap_Kd -mm 0.2 1 a.png\nmap_Ke -mm 0 1 b.png\n"), "texture-option-ignored"),
      (std::vector<std::string>{"/materials/m/map_Kd"}));
}

TEST(Mtl, NumbersThatCannotBeReadCostNoMore) {
  const Scene scene = square_of("newmtl m\nKd spectral red.rfl\nKs 1 1\nNs 98 # shiny\nd -halo 0.5\n");
  EXPECT_EQ(places(scene, "value-ignored"), (std::vector<std::string>{"/materials/m/Kd", "/materials/m/Ks"}));
  EXPECT_EQ(scene.materials.at(0).base_color.a, 0.5f);
  EXPECT_LT(scene.materials.at(0).perceptual_roughness, 0.5f);
  const glm::vec4 grey = square_of("newmtl m\nKd 0.5\n").materials.at(0).base_color;
  EXPECT_EQ(grey.g, grey.r);
  EXPECT_EQ(grey.b, grey.r);
}

TEST(Mtl, RemembersABoundedNumberOfStatements) {
  std::string mtl = "newmtl m\n";
  for (std::size_t i = 0; i < kMostMtlTextures + 5; ++i) mtl += "map_x a\n";
  for (std::size_t i = 0; i < kMostMtlMaterials + 5; ++i) mtl += "newmtl " + std::to_string(i) + "\n";
  GltfNotes notes;
  const MtlText text = read_mtl(mtl, notes);
  EXPECT_EQ(text.materials.size(), kMostMtlMaterials);
  EXPECT_EQ(text.materials.at("m").size(), kMostMtlTextures);
}

TEST(Obj, BeginsWithAMark) {
  const Scene scene = import_text("\xef\xbb\xbfmtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n",
                                  {{"m.mtl", "\xef\xbb\xbfnewmtl m\nKd 1 0 0\n"}});
  EXPECT_EQ(scene.materials.at(0).base_color, glm::vec4(1, 0, 0, 1));
  const Scene bare = import_text("\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(bare.meshes.at(0)->indices.size(), 3u);
}

TEST(Obj, ALineNamesSeveralLibraries) {
  EXPECT_EQ(material_libraries("mtllib a.mtl my b.MTL  c.mtl\n"),
            (std::vector<std::string>{"a.mtl", "my b.MTL", "c.mtl"}));
  EXPECT_EQ(material_libraries("mtllib a.mtl.old\n"), (std::vector<std::string>{"a.mtl.old"}));
}

TEST(Obj, TellsOfMaterialsThatNobodyHas) {
  EXPECT_EQ(places(square_of("newmtl other\nKd 1 0 0\n"), "material-missing"),
            (std::vector<std::string>{"/usemtl/m"}));
  EXPECT_EQ(places(import_text(kSquare), "material-missing"), (std::vector<std::string>{"/usemtl/m"}));
  EXPECT_FALSE(has_note(square_of("newmtl m\nKd 1 0 0\n"), "material-missing"));
}

TEST(Obj, TellsOfFreeForms) {
  const std::string curve = "cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\n";
  EXPECT_TRUE(has_note(import_text(kSquare + curve), "geometry-ignored"));
  const std::string message = error_of("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + curve).message;
  EXPECT_NE(message.find("free-form"), std::string::npos) << message;
}

TEST(Obj, VerticesAloneArePoints) {
  const Scene scene = import_text("# scanned\nv 1 2 3 255 0 0\nv 4 5 6 0 51 255\n");
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = *scene.meshes[0];
  EXPECT_EQ(mesh.topology, Topology::kPoints);
  EXPECT_EQ(mesh.positions.at(1), glm::vec3(4, 5, 6));
  EXPECT_EQ(mesh.colors.at(0), glm::vec4(1, 0, 0, 1));
  EXPECT_GT(mesh.colors.at(1).g, 0);
  EXPECT_LT(mesh.colors.at(1).g, 0.1f);
  EXPECT_TRUE(import_text("v 1 2 3\nv 4 5 6\n").meshes.at(0)->colors.empty());
  EXPECT_NE(error_of("v 1 2 3\nv 4 5\n").message.find("vertex 2 has 2 of its 3"), std::string::npos);
}

TEST(Obj, ColoursMayBeBytes) {
  const Scene scene = import_text("v 0 0 0 255 0 0\nv 1 0 0 0 255 0\nv 0 1 0 0 51 255\nf 1 2 3\n");
  for (const glm::vec4& color : scene.meshes.at(0)->colors)
    EXPECT_TRUE(color.g < 0.1f || color.g == 1) << color.g;
}

}  // namespace
}  // namespace furnace
