// What a model is, and which files belong to it, by its bytes.
#include "renderer/scene/model_format.hpp"

#include <gtest/gtest.h>

#include "renderer/base/blob.hpp"
#include "tests/support/model_files.hpp"

namespace furnace {
namespace {

using Names = std::vector<std::string>;

ModelFormat format_of(const std::string& bytes, std::string_view name = "") {
  return model_format(Blob(bytes), name);
}

TEST(ModelFormat, IsToldByContentWhateverTheName) {
  EXPECT_EQ(format_of(test::obj_corner(), "a.glb"), ModelFormat::kObj);
  EXPECT_EQ(format_of("\r\n# only vertices\r\nv 1 2 3\r\n", "a.stl"), ModelFormat::kObj);
  EXPECT_EQ(format_of(test::text_stl(), "a.obj"), ModelFormat::kStl);
  EXPECT_EQ(format_of(test::binary_stl("solid no text", {}), "a.ply"), ModelFormat::kStl);
  EXPECT_EQ(format_of(test::ply_square(test::PlyForm::kBig), "a.stl"), ModelFormat::kPly);
  EXPECT_EQ(format_of("glTF....", "a.obj"), ModelFormat::kGltf);
  EXPECT_EQ(format_of("\xef\xbb\xbf {\"asset\":{}}", "a.stl"), ModelFormat::kGltf);
}

TEST(ModelFormat, TheNameCountsWhereContentDoesNotTell) {
  EXPECT_EQ(format_of("anything", "part:A.OBJ"), ModelFormat::kObj);
  EXPECT_EQ(format_of("", "a.stl"), ModelFormat::kStl);
  EXPECT_EQ(format_of("v for victory", "b/a.ply"), ModelFormat::kPly);
  EXPECT_EQ(format_of("anything", "part:model"), ModelFormat::kGltf);
  EXPECT_TRUE(is_model_name("x/THING.Stl"));
  EXPECT_FALSE(is_model_name("request.json"));
}

TEST(ModelFormat, SizesOfBinaryStlAgree) {
  const std::string whole = test::binary_stl("x", {});
  EXPECT_EQ(binary_stl_facets(Blob(whole)), 3u);
  EXPECT_FALSE(binary_stl_facets(Blob(whole.substr(0, whole.size() - 1))));
  EXPECT_FALSE(binary_stl_facets(Blob(whole + "x")));
  EXPECT_FALSE(binary_stl_facets(Blob("short")));
}

TEST(ModelFormat, NamesOfSiblingsStayBesideTheModel) {
  EXPECT_EQ(sibling_name(" tex\\my wood.png \r"), "tex/my wood.png");
  EXPECT_EQ(sibling_name("././a.png"), "a.png");
  for (const char* far : {"C:\\Users\\me\\a.png", "/far/away/a.png", "../../a.png", "x/../a.png",
                          "file:a.png", "http://h/a.png"})
    EXPECT_EQ(sibling_name(far), "a.png") << far;
  for (const char* none : {"", " ", "..", "/", "a/", "C:", "x/..", "a\xff.png", "a\x01.png"})
    EXPECT_FALSE(sibling_name(none)) << none;
  EXPECT_FALSE(sibling_name(std::string(2000, 'a')));
}

TEST(ModelFormat, FindsWhatFilesName) {
  EXPECT_EQ(material_libraries("mtllib a b.mtl\nv 1 2 3\n# mtllib no.mtl\n\tmtllib c.mtl\r\nmtllib a b.mtl"),
            (Names{"a b.mtl", "c.mtl"}));
  EXPECT_EQ(texture_names("newmtl x\n map_Kd -o 1 2 -clamp on -mm 0 1 a b.png\nbump -bm 2 n.png\nKd 1 1 1\n"
                          "map_d -imfchan m a b.png\nnorm -s 1 1 1 o.png\nmap_Ks\n"),
            (Names{"a b.png", "n.png", "o.png"}));
  EXPECT_EQ(ply_texture_names("ply\ncomment TextureFile skin.png\nend_header\ncomment TextureFile no.png\n"),
            Names{"skin.png"});
  std::string many;
  for (int i = 0; i < 3000; ++i) many += "map_Kd " + std::to_string(i) + "\n";
  EXPECT_EQ(texture_names(many).size(), kMostSiblings);
}

TEST(ModelFormat, TextIsMadeReadable) {
  EXPECT_EQ(readable_text("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x94\xa5"),
            "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x94\xa5");
  EXPECT_EQ(readable_text("a\xe9\x01z\xc0\xaf\xed\xa0\x80"), "a??z?????");
  EXPECT_EQ(readable_text("\xf0\x9f\x94"), "???");
}

}  // namespace
}  // namespace furnace
