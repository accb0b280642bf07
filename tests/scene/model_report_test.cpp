// The report of a document whose every number is known, of real models, and of garbage.
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/scene/model_report.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include <gmock/gmock.h>

#include "tests/scene/gltf_samples.hpp"
#include "tests/support/model_files.hpp"

namespace furnace::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A PNG of 40 x 30 px, eight bits of RGB, as far as a header goes.
std::string png_header(int width, int height, char depth = 8, char color_type = 2) {
  std::string file = kPngStart + std::string("\0\0\0\x0dIHDR", 8);
  for (const int side : {width, height})
    for (int shift = 24; shift >= 0; shift -= 8) file += static_cast<char>(side >> shift);
  return file + depth + color_type + std::string(3, '\0') + std::string(4, '\0');
}

ModelReport inspect(const GltfBuilder& builder, const ImportOptions& options = {},
                    const ReportLimits& limits = {}, std::map<std::string, std::string> files = {}) {
  ModelBundle bundle = builder.bundle();
  for (const auto& [name, content] : files) bundle.siblings[name] = Blob(content);
  bundle.seal();
  return inspect_gltf(decode::in_process_decoder(), bundle, options, {}, Deadline(), limits);
}

const std::map<std::string, std::string> kFiles = {{"color.png", png_header(40, 30)}};

TEST(ModelReport, SaysWhereItComesFromAndWhatIsDrawn) {
  const GltfBuilder builder = furnished_builder();
  const ModelReport report = inspect(builder, {}, {}, kFiles);
  EXPECT_EQ(report.asset.container, "gltf");
  EXPECT_EQ(report.asset.version, "2.0");
  EXPECT_EQ(report.asset.generator, "by hand");
  EXPECT_EQ(report.asset.copyright, "nobody");
  ASSERT_EQ(report.scenes.items.size(), 2u);
  EXPECT_EQ(report.scenes.items[0].name, "main");
  EXPECT_EQ(report.scenes.items[0].nodes, 3);
  EXPECT_EQ(report.scenes.items[1].nodes, 2);
  EXPECT_EQ(report.default_scene, 0);
  EXPECT_EQ(report.nodes, 4);
  EXPECT_EQ(report.vertices, 4);

  EXPECT_EQ(report.drawn.scene, 0);
  EXPECT_EQ(report.drawn.nodes, 3);
  EXPECT_EQ(report.drawn.instances, 2);
  EXPECT_EQ(report.drawn.meshes, 1);
  EXPECT_EQ(report.drawn.vertices, 8);
  EXPECT_EQ(report.drawn.triangles, 4);
  EXPECT_EQ(report.drawn.lines + report.drawn.points, 0);
  EXPECT_EQ(report.drawn.bounds.min, glm::vec3(0));
  EXPECT_EQ(report.drawn.bounds.max, glm::vec3(12, 3, 0));
  const ModelReport second = inspect(builder, {.scene = 1, .variant = {}}, {}, kFiles);
  EXPECT_EQ(second.drawn.scene, 1);
  EXPECT_EQ(second.drawn.instances, 1);
  EXPECT_EQ(second.drawn.bounds.min, glm::vec3(10, 0, 0));
}

TEST(ModelReport, Meshes) {
  const ModelReport report = inspect(furnished_builder(), {}, {}, kFiles);
  ASSERT_EQ(report.meshes.items.size(), 1u);
  EXPECT_EQ(report.meshes.items[0].nodes, 2);
  ASSERT_EQ(report.meshes.items[0].primitives.items.size(), 1u);
  const ModelReport::Primitive& primitive = report.meshes.items[0].primitives.items[0];
  EXPECT_EQ(primitive.mode, 4);
  EXPECT_EQ(primitive.vertices, 4);
  EXPECT_EQ(primitive.elements, 2);
  EXPECT_EQ(primitive.index_component, "unsigned short");
  EXPECT_EQ(primitive.material, 0);
  ASSERT_EQ(primitive.attributes.items.size(), 3u);
  EXPECT_EQ(primitive.attributes.items[2].semantic, "TEXCOORD_0");
  EXPECT_EQ(primitive.attributes.items[2].type, "VEC2");
  EXPECT_EQ(primitive.attributes.items[2].component, "unsigned short");
  EXPECT_TRUE(primitive.attributes.items[2].normalized);
  ASSERT_TRUE(primitive.declared && primitive.bounds);
  EXPECT_EQ(primitive.declared->max, glm::vec3(2, 3, 1));
  EXPECT_EQ(primitive.bounds->max, glm::vec3(2, 3, 0));
}

TEST(ModelReport, MaterialsAndImages) {
  const ModelReport report = inspect(furnished_builder(), {}, {}, kFiles);
  ASSERT_EQ(report.materials.items.size(), 2u);
  const ModelReport::MaterialInfo& wood = report.materials.items[0];
  EXPECT_EQ(wood.name, "wood");
  EXPECT_EQ(wood.alpha_mode, AlphaMode::kMask);
  EXPECT_TRUE(wood.double_sided);
  EXPECT_THAT(wood.extensions.items, ElementsAre("KHR_materials_ior"));
  ASSERT_EQ(wood.textures.items.size(), 1u);
  EXPECT_EQ(wood.textures.items[0].use, "baseColor");
  EXPECT_EQ(wood.textures.items[0].image, 0);

  ASSERT_EQ(report.images.items.size(), 2u);
  const ModelReport::ImageInfo& color = report.images.items[0];
  EXPECT_EQ(color.uri, "color.png");
  EXPECT_EQ(color.format, "PNG");
  EXPECT_EQ(color.width, 40u);
  EXPECT_EQ(color.height, 30u);
  EXPECT_EQ(color.channels, 3);
  EXPECT_EQ(color.decoded_bytes, 40 * 30 * 3);
  // 40x30, 20x15, 10x7, 5x3, 2x1, 1x1; once as colour and once as normals.
  EXPECT_EQ(color.gpu_bytes, 2 * 4 * (1200 + 300 + 70 + 15 + 2 + 1));
  EXPECT_TRUE(report.images.items[1].missing);
  EXPECT_THAT(report.missing_files.items, ElementsAre("gone.png"));
  EXPECT_EQ(report.bytes.images_gpu, color.gpu_bytes);
}

TEST(ModelReport, AnimationsVariantsExtensionsAndWhatNothingUses) {
  const ModelReport report = inspect(furnished_builder(), {}, {}, kFiles);
  ASSERT_EQ(report.animations.items.size(), 1u);
  EXPECT_EQ(report.animations.items[0].name, "slide");
  EXPECT_EQ(report.animations.items[0].duration_s, 1.25);
  ASSERT_EQ(report.animations.items[0].channels.items.size(), 1u);
  EXPECT_EQ(report.animations.items[0].channels.items[0].target, "/nodes/0/translation");
  EXPECT_EQ(report.animations.items[0].channels.items[0].interpolation, "STEP");
  EXPECT_EQ(report.animations.items[0].channels.items[0].keyframes, 3);
  EXPECT_THAT(report.variants.items, ElementsAre("day", "night"));
  EXPECT_THAT(report.extensions.unsupported.items, ElementsAre("MY_extension"));
  GltfBuilder undeclared = furnished_builder();
  undeclared.json["nodes"][0]["extensions"]["ITS_extension"] = Json::object();
  EXPECT_THAT(inspect(undeclared, {}, {}, kFiles).extensions.unsupported.items,
              ElementsAre("MY_extension", "ITS_extension"));
  EXPECT_THAT(report.unused.nodes.items, ElementsAre(3));
  EXPECT_THAT(report.unused.cameras.items, ElementsAre(0));
  EXPECT_THAT(report.unused.materials.items, ElementsAre(1));
  EXPECT_THAT(report.unused.textures.items, ElementsAre(1));
  EXPECT_THAT(report.unused.images.items, ElementsAre(1));
  EXPECT_THAT(report.unused.accessors.items, IsEmpty());
  EXPECT_THAT(report.unused.buffer_views.items, IsEmpty());
  std::vector<std::string> codes;
  for (const Note& note : report.notes) codes.push_back(note.code);
  EXPECT_THAT(codes, ElementsAre("extension-ignored", "image-missing"));
}

TEST(ModelReport, RefusesWhatARenderRefuses) {
  GltfBuilder builder = furnished_builder();
  const auto pointer = [&](const ImportOptions& options = {}) {
    const auto error = error_of([&] { inspect(builder, options, {}, kFiles); });
    return error ? error->pointer : "no error";
  };
  EXPECT_EQ(pointer({.scene = -1, .variant = "dusk"}), "/extensions/KHR_materials_variants/variants");
  EXPECT_EQ(pointer({.scene = 2, .variant = {}}), "/scenes");
  builder.json["extensionsRequired"] = {"MY_extension"};
  EXPECT_EQ(pointer(), "/extensionsRequired/0");
  builder.json.erase("extensionsRequired");
  builder.json["meshes"][0]["primitives"][0]["indices"] = 99;
  EXPECT_EQ(pointer(), "/meshes/0/primitives/0/indices");
}

TEST(ModelReport, AnAnimationThatCannotBePlayedIsANote) {
  GltfBuilder builder = furnished_builder();
  builder.json["animations"][0]["samplers"][0]["input"] = builder.add_accessor<float>("SCALAR", {1, 1, 0});
  const ModelReport report = inspect(builder, {}, {}, kFiles);
  const auto is_it = [](const Note& note) {
    return note.code == "animation-damaged" && note.pointer == "/animations/0/samplers/0/input";
  };
  EXPECT_EQ(std::count_if(report.notes.begin(), report.notes.end(), is_it), 1);
}

TEST(ModelReport, LongListsAreCutAndCounted) {
  GltfBuilder builder = furnished_builder();
  for (int i = 0; i < 30; ++i) builder.add("materials", {{"name", std::string(5000, 'x')}});
  const ReportLimits limits{.max_items = 10, .max_items_total = 60, .max_text_bytes = 20};
  const ModelReport report = inspect(builder, {}, limits, kFiles);
  EXPECT_EQ(report.materials.items.size(), 10u);
  EXPECT_EQ(report.materials.more, 22);
  EXPECT_EQ(report.materials.items.back().name, std::string(20, 'x') + "...");
  EXPECT_EQ(report.unused.materials.size(), 31);
  const ReportLimits none{.max_items = 10, .max_items_total = 0, .max_text_bytes = 20};
  EXPECT_EQ(inspect(builder, {}, none, kFiles).materials.more, 32);
}

// Inspecting succeeds exactly where importing does.
TEST(ModelReport, DamageEndsAsItDoesForTheImporter) {
  const ModelBundle whole = furnished_builder().bundle();
  std::mt19937 random(7);
  int read = 0;
  for (int round = 0; round < 600; ++round) {
    std::string damaged(whole.document.text());
    if (round % 3 == 0) damaged.resize(random() % damaged.size());
    for (int i = 0; i < 1 + round % 4 && !damaged.empty(); ++i)
      damaged[random() % damaged.size()] =
          static_cast<char>(round % 2 == 0 ? '0' + random() % 10 : random() % 128);
    ModelBundle bundle = whole;
    bundle.document = Blob(damaged);
    bundle.seal();
    const auto imported =
        error_of([&] { import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline()); });
    const auto inspected =
        error_of([&] { inspect_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline()); });
    ASSERT_EQ(imported.has_value(), inspected.has_value())
        << damaged << (inspected ? inspected->message : "");
    if (imported) {
      EXPECT_EQ(imported->pointer, inspected->pointer);
    } else {
      ++read;
    }
  }
  EXPECT_GT(read, 25);
}

Blob load(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return Blob(text.str());
}

ModelReport inspect_file(const fs::path& path) {
  ModelBundle bundle;
  bundle.document = load(path);
  for (const std::string& uri : gltf_external_uris(bundle.document, {})) {
    std::error_code none;
    if (fs::is_regular_file(path.parent_path() / uri, none))
      bundle.siblings[uri] = load(path.parent_path() / uri);
  }
  bundle.seal();
  return inspect_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
}

const fs::path kModels = "../shared/data/models";

TEST(ModelReport, RealModels) {
  if (!fs::exists(kModels)) GTEST_SKIP() << "needs the test data in " << fs::absolute(kModels);
  const ModelReport fox = inspect_file(kModels / "Fox.glb");
  EXPECT_EQ(fox.asset.container, "glb");
  ASSERT_EQ(fox.animations.items.size(), 3u);
  EXPECT_EQ(fox.animations.items[0].name, "Survey");
  EXPECT_NEAR(fox.animations.items[0].duration_s, 3.4166667, 1e-6);
  ASSERT_EQ(fox.skins.items.size(), 1u);
  EXPECT_EQ(fox.skins.items[0].joints, 24);
  EXPECT_EQ(fox.drawn.triangles, 576);
  EXPECT_THAT(fox.unused.accessors.items, IsEmpty());

  const ModelReport box = inspect_file(kModels / "Box.glb");
  EXPECT_EQ(box.drawn.triangles, 12);
  EXPECT_EQ(box.drawn.bounds.max, glm::vec3(0.5f));
  EXPECT_THAT(box.notes, IsEmpty());

  const ModelReport helmet = inspect_file(kModels / "FlightHelmet" / "FlightHelmet.gltf");
  EXPECT_THAT(helmet.missing_files.items, IsEmpty());
  EXPECT_EQ(helmet.images.size(), 15);
  for (const auto& image : helmet.images.items) EXPECT_EQ(image.format, "PNG") << image.uri;
}

ModelReport inspect_plain_model(const std::string& document, ModelFormat format,
                                std::map<std::string, Blob> siblings = {}) {
  ModelBundle bundle;
  bundle.document = Blob(document);
  bundle.format = format;
  bundle.siblings = std::move(siblings);
  bundle.seal();
  return inspect_model(decode::in_process_decoder(), bundle, {}, {}, Deadline());
}

TEST(PlainModelReport, TellsWhatWasImported) {
  const ModelReport report =
      inspect_plain_model(test::obj_corner(), ModelFormat::kObj, {{"corner.mtl", Blob(test::mtl_corner())}});
  EXPECT_EQ(report.asset.container, "obj");
  EXPECT_EQ(report.drawn.triangles, 6);
  ASSERT_EQ(report.meshes.size(), 2);
  const ModelReport::Primitive& part = report.meshes.items[0].primitives.items.at(0);
  EXPECT_EQ(part.elements, 2);
  EXPECT_EQ(part.mode, 4);
  ASSERT_TRUE(part.bounds);
  std::vector<std::string> semantics;
  for (const ModelReport::Attribute& attribute : part.attributes.items)
    semantics.push_back(attribute.semantic);
  EXPECT_THAT(semantics, ::testing::IsSupersetOf({"POSITION", "NORMAL", "TEXCOORD_0"}));
  EXPECT_EQ(report.materials.size(), 2);
  EXPECT_EQ(report.bytes.document, std::int64_t(test::obj_corner().size()));
  EXPECT_EQ(report.drawn.bounds.max, glm::vec3(1));
}

TEST(PlainModelReport, OfEveryFormat) {
  const ModelReport stl = inspect_plain_model(test::text_stl(), ModelFormat::kStl);
  EXPECT_EQ(stl.asset.container, "stl");
  EXPECT_GT(stl.drawn.triangles, 0);
  const ModelReport cloud = inspect_plain_model(test::ply_cloud(), ModelFormat::kPly);
  EXPECT_EQ(cloud.asset.container, "ply");
  EXPECT_EQ(cloud.drawn.points, 3);
  EXPECT_EQ(cloud.meshes.items.at(0).primitives.items.at(0).mode, 0);
}

TEST(PlainModelReport, WhatIsMissingIsTold) {
  const ModelReport report = inspect_plain_model(test::obj_corner(), ModelFormat::kObj);
  EXPECT_THAT(report.missing_files.items, ::testing::ElementsAre("corner.mtl"));
  EXPECT_FALSE(report.notes.empty());
  const ModelReport without_textures =
      inspect_plain_model(test::obj_corner(), ModelFormat::kObj, {{"corner.mtl", Blob(test::mtl_corner())}});
  EXPECT_THAT(without_textures.missing_files.items,
              ::testing::ElementsAre("my paint.png", "bump.png", "shine.png"));
}

TEST(PlainModelReport, TexturesAreAsTheirMaterialsPlaceThem) {
  const ModelReport report = inspect_plain_model(
      "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n", ModelFormat::kObj,
      {{"m.mtl", Blob("newmtl m\nmap_Kd -clamp on -s 2 2 a.png\n")}, {"a.png", Blob(png_header(4, 4))}});
  ASSERT_EQ(report.textures.size(), 1);
  EXPECT_EQ(report.textures.items[0].sampler.wrap_u, Wrap::kClampToEdge);
  EXPECT_TRUE(report.materials.items.at(0).textures.items.at(0).transformed);
}

TEST(PlainModelReport, HasNoScenesAndNoVariants) {
  ModelBundle bundle;
  bundle.document = Blob(test::text_stl());
  bundle.format = ModelFormat::kStl;
  ImportOptions options;
  options.scene = 0;
  EXPECT_THROW(inspect_model(decode::in_process_decoder(), bundle, options, {}, Deadline()), Error);
  options = {};
  options.variant = "a";
  EXPECT_THROW(inspect_model(decode::in_process_decoder(), bundle, options, {}, Deadline()), Error);
}

}  // namespace
}  // namespace furnace::testing
