// STL files that are not quite right: read where it is clear what is meant, else refused with what is wrong.
#include <gtest/gtest.h>

#include "renderer/scene/model_format.hpp"
#include "tests/scene/model_scenes.hpp"
#include "tests/support/model_files.hpp"

namespace furnace {
namespace {

using namespace test;

std::size_t triangles(const Scene& scene) {
  return scene.meshes.at(0)->indices.size() / 3;
}

// As a file whose name says what it is.
ModelBundle stl_of(const std::string& document) {
  ModelBundle bundle;
  bundle.document = Blob(document);
  bundle.format = ModelFormat::kStl;
  return bundle;
}

std::string fault_of(const std::string& document) {
  try {
    import_model(stl_of(document), {}, {}, decode::in_process_decoder(), Deadline());
  } catch (const Error& error) {
    return error.message;
  }
  return {};
}

TEST(Stl, BytesBehindTheFacetsDoNotCount) {
  const Scene scene = import_model(stl_of(binary_stl("x", {}) + "made by a careless program"), {}, {},
                                   decode::in_process_decoder(), Deadline());
  EXPECT_EQ(triangles(scene), 3u);
}

TEST(Stl, ABinaryFileThatIsCutOffSaysSo) {
  const std::string whole = binary_stl("x", {});
  EXPECT_NE(fault_of(whole.substr(0, whole.size() - 1)).find("3 facets, which take 234 bytes, and has 233"),
            std::string::npos);
  EXPECT_NE(fault_of("short").find("too short"), std::string::npos);
}

TEST(Stl, ATextThatIsCutOffSaysSo) {
  const std::string whole = text_stl();
  const std::string within = whole.substr(0, whole.rfind("vertex"));
  EXPECT_NE(error_of(within).message.find("facet 1 has 2 of its 3 vertices"), std::string::npos);
  EXPECT_FALSE(has_note(import_text(whole), "file-incomplete"));
  EXPECT_TRUE(has_note(import_text(whole.substr(0, whole.find("endsolid"))), "file-incomplete"));
}

TEST(Stl, NumbersBeyondAFloatAreNotZero) {
  const auto with = [](const std::string& number) {
    std::string text = text_stl();
    return text.replace(text.find("vertex 2"), 8, "vertex " + number);
  };
  for (const std::string number : {"1e999", "1e60", "nan", "1,5"})
    EXPECT_NE(error_of(with(number)).message.find('"' + number + '"'), std::string::npos) << number;
  EXPECT_EQ(import_text(with("+2.5E+0")).meshes.at(0)->bounds.max.x, 2.5f);
  EXPECT_EQ(import_text(with("1e-999")).meshes.at(0)->bounds.max.x, 0.0f);
}

TEST(Stl, MoreCornersAreAFanAndNamesAreNoKeywords) {
  const Scene scene = import_text(
      "SOLID vertex of facet\nFacet Normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 "
      "0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid vertex of facet\n");
  EXPECT_EQ(triangles(scene), 2u);
}

}  // namespace
}  // namespace furnace
