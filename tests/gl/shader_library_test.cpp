#include "renderer/gl/shader_library.hpp"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"

namespace furnace::gl {
namespace {

using testing::HasSubstr;

std::string refusal(ShaderLibrary& library, const std::string& path) {
  try {
    library.expand(path, 0);
  } catch (const Error& error) {
    return error.message;
  }
  return "accepted";
}

TEST(ShaderLibrary, IncludesEachFileOnceAndRemembersLines) {
  ShaderLibrary library({});
  library.add("a.glsl", "#include \"b.glsl\"\n#include \"b.glsl\"\nfloat a;\n");
  library.add("b.glsl", "// first\nfloat b;\n");
  const ExpandedShader shader = library.expand("a.glsl", 0);
  EXPECT_EQ(shader.text.find("float b;"), shader.text.rfind("float b;"));
  ASSERT_GE(shader.lines.size(), 3u);
  const SourceLine& last = shader.lines.back();
  EXPECT_EQ(last.path, "a.glsl");
  EXPECT_EQ(last.line, 3);
  EXPECT_EQ(shader.lines[shader.lines.size() - 2].path, "b.glsl");
  EXPECT_EQ(shader.lines[shader.lines.size() - 2].line, 2);
}

TEST(ShaderLibrary, RefusesUnknownFeatures) {
  ShaderLibrary library({});
  library.add("typo.glsl", "\n#if FEATURE_TYPO\n#endif\n");
  EXPECT_THAT(refusal(library, "typo.glsl"), HasSubstr("shaders/typo.glsl:2: FEATURE_TYPO"));
}

TEST(ShaderLibrary, RefusesCyclesWithTheirChain) {
  ShaderLibrary library({});
  library.add("a.glsl", "#include \"b.glsl\"\n");
  library.add("b.glsl", "#include \"a.glsl\"\n");
  EXPECT_THAT(refusal(library, "a.glsl"), HasSubstr("a.glsl -> b.glsl -> a.glsl"));
}

TEST(ShaderLibrary, NamesAMissingFile) {
  ShaderLibrary library({});
  EXPECT_THAT(refusal(library, "nowhere.glsl"), HasSubstr("nowhere.glsl"));
}

TEST(ShaderLibrary, DefinesEveryFeatureAsZeroOrOne) {
  ShaderLibrary library({});
  library.add("a.glsl", "");
  const ExpandedShader shader = library.expand("a.glsl", kFeatureUnlit);
  EXPECT_THAT(shader.text, HasSubstr("#define FEATURE_UNLIT 1\n"));
  EXPECT_THAT(shader.text, HasSubstr("#define FEATURE_ALPHA_MASK 0\n"));
}

TEST(ShaderLibrary, FeatureBitsAreTheListOfTheInterface) {
  ShaderLibrary library({});
  const std::vector<std::string> names = library.feature_names();
  const std::pair<FeatureSet, const char*> expected[] = {
      {kFeatureAlphaMask, "FEATURE_ALPHA_MASK"},
      {kFeatureAlphaBlend, "FEATURE_ALPHA_BLEND"},
      {kFeatureUnlit, "FEATURE_UNLIT"},
      {kFeatureNormalMap, "FEATURE_NORMAL_MAP"},
      {kFeatureMaterialMaps, "FEATURE_MATERIAL_MAPS"},
      {kFeaturePackedOcclusion, "FEATURE_PACKED_OCCLUSION"},
      {kFeatureEmissiveMap, "FEATURE_EMISSIVE_MAP"},
      {kFeatureAlignedMaps, "FEATURE_ALIGNED_MAPS"},
      {kFeatureVertexColor, "FEATURE_VERTEX_COLOR"},
      {kFeatureSharpReflection, "FEATURE_SHARP_REFLECTION"},
      {kFeatureLights, "FEATURE_LIGHTS"},
      {kFeatureLayerMaps, "FEATURE_LAYER_MAPS"},
      {kFeatureSpecular, "FEATURE_SPECULAR"},
      {kFeatureGlossy, "FEATURE_GLOSSY"},
      {kFeatureAnisotropy, "FEATURE_ANISOTROPY"},
      {kFeatureIridescence, "FEATURE_IRIDESCENCE"},
      {kFeatureClearcoat, "FEATURE_CLEARCOAT"},
      {kFeatureCoatNormalMap, "FEATURE_COAT_NORMAL_MAP"},
      {kFeatureSheen, "FEATURE_SHEEN"},
      {kFeatureDiffuseTransmission, "FEATURE_DIFFUSE_TRANSMISSION"},
      {kFeatureTransmission, "FEATURE_TRANSMISSION"},
      {kFeatureSchlickBeckmann, "FEATURE_SCHLICK_BECKMANN"},
      {kFeaturePhong, "FEATURE_PHONG"},
      {kFeatureVeil, "FEATURE_VEIL"},
      {kFeatureSky, "FEATURE_SKY"},
      {kFeatureMagnified, "FEATURE_MAGNIFIED"},
      {kFeatureGroundProjection, "FEATURE_GROUND_PROJECTION"},
      {kFeatureGroundShadow, "FEATURE_GROUND_SHADOW"},
      {kFeatureGrade, "FEATURE_GRADE"},
      {kFeatureBloom, "FEATURE_BLOOM"},
      {kFeatureEmission, "FEATURE_EMISSION"},
      {kFeatureSurfaceLights, "FEATURE_SURFACE_LIGHTS"},
      {kFeatureLightProfiles, "FEATURE_LIGHT_PROFILES"},
      {kFeatureSurfaceValue, "FEATURE_SURFACE_VALUE"},
      {kFeatureLightPart, "FEATURE_LIGHT_PART"},
      {kFeatureLightTerm, "FEATURE_LIGHT_TERM"},
      {kFeatureNearest, "FEATURE_NEAREST"},
      {kFeatureEnvironmentVisibility, "FEATURE_ENVIRONMENT_VISIBILITY"},
      {kFeatureDither, "FEATURE_DITHER"}};
  ASSERT_EQ(names.size(), std::size(expected));
  for (std::size_t bit = 0; bit < names.size(); ++bit) {
    EXPECT_EQ(expected[bit].first, FeatureSet(1) << bit);
    EXPECT_EQ(expected[bit].second, names[bit]);
  }
}

TEST(ShaderLibrary, MapsTheLogsOfMesaNvidiaAndIntel) {
  ExpandedShader shader;
  for (int i = 1; i <= 20; ++i) shader.lines.push_back({"lib/brdf.glsl", i + 30});
  EXPECT_EQ(map_driver_log("0:12(7): error: x", shader), "shaders/lib/brdf.glsl:42: error: x");
  EXPECT_EQ(map_driver_log("0(12) : error C1: x", shader), "shaders/lib/brdf.glsl:42 : error C1: x");
  EXPECT_EQ(map_driver_log("ERROR: 0:12: x", shader), "ERROR: shaders/lib/brdf.glsl:42: x");
  EXPECT_EQ(map_driver_log("0:99(1): x", shader), "0:99(1): x");
}

TEST(ShaderLibrary, FolderSourcesReloadWhenTheyChange) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "furnace_shader_reload";
  std::filesystem::create_directories(folder / "interface");
  const auto write = [&](const char* path, const char* text) { std::ofstream(folder / path) << text; };
  write("interface/features.glsl", "// FEATURE_X  one\n");
  write("a.glsl", "float before;\n");
  ShaderLibrary library(folder);
  EXPECT_THAT(library.expand("a.glsl", 0).text, HasSubstr("before"));
  EXPECT_FALSE(library.reload_if_changed());
  write("a.glsl", "float after;\n");
  std::filesystem::last_write_time(
      folder / "a.glsl", std::filesystem::last_write_time(folder / "a.glsl") + std::chrono::seconds(2));
  EXPECT_TRUE(library.reload_if_changed());
  EXPECT_THAT(library.expand("a.glsl", 0).text, HasSubstr("after"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace furnace::gl
