// Real models and other loaders' broken ones, where the shared test data lie beside the checkout.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

namespace fs = std::filesystem;

const fs::path kModels = "../shared/data/models";
const fs::path kMalformed = "../shared/data/malformed";

Blob load(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return Blob(text.str());
}

Scene import_document(const Blob& document, const fs::path& folder) {
  ModelBundle bundle;
  bundle.document = document;
  for (const std::string& uri : gltf_external_uris(document, {})) {
    std::error_code none;
    if (fs::is_regular_file(folder / uri, none)) bundle.siblings[uri] = load(folder / uri);
  }
  bundle.seal();
  return import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
}

Scene import_file(const fs::path& path) {
  return import_document(load(path), path.parent_path());
}

std::vector<fs::path> files_below(const fs::path& root) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_model(const fs::path& path) {
  return path.extension() == ".gltf" || path.extension() == ".glb";
}

#define SKIP_WITHOUT(folder) \
  if (!fs::exists(folder)) GTEST_SKIP() << "needs the test data in " << fs::absolute(folder)

TEST(Models, EveryOneImportsOrRequiresWhatIsNotSupported) {
  SKIP_WITHOUT(kModels);
  int imported = 0;
  for (const fs::path& path : files_below(kModels)) {
    if (!is_model(path)) continue;
    const auto error = error_of([&] {
      const Scene scene = import_file(path);
      EXPECT_FALSE(scene.instances.empty()) << path;
      EXPECT_FALSE(world_bounds(scene).empty()) << path;
    });
    if (!error) {
      ++imported;
      continue;
    }
    const bool future = error->pointer == "/asset/minVersion";  // Compatibility_04 asks for a version to come
    EXPECT_TRUE(future || error->pointer.starts_with("/extensionsRequired/"))
        << path << " " << error->pointer << " " << error->message;
  }
  EXPECT_GT(imported, 100);
}

// The same cube, once as floats and once quantised.
TEST(Models, QuantizationChangesLittle) {
  SKIP_WITHOUT(kModels);
  const Scene plain = import_file(kModels / "AnimatedMorphCube.glb");
  const Scene quantized = import_file(kModels / "AnimatedMorphCube-Quantized/AnimatedMorphCube.gltf");
  const Bounds a = world_bounds(plain), b = world_bounds(quantized);
  EXPECT_LT(glm::distance(a.min, b.min), 1e-3f);  // 16 bits over a cube of 2 m
  EXPECT_LT(glm::distance(a.max, b.max), 1e-3f);
}

// The same models, once plain and once compressed.
TEST(Models, DracoChangesLittle) {
  SKIP_WITHOUT(kModels);
  for (const char* name : {"MorphPrimitivesTest", "RiggedSimple"}) {
    const std::string text(name);
    const Scene plain = import_file(kModels / (text + ".glb"));
    const Scene compressed = import_file(kModels / (text + "-Draco") / (text + ".gltf"));
    const Bounds a = world_bounds(plain), b = world_bounds(compressed);
    const float size = glm::distance(a.min, a.max);
    EXPECT_LT(glm::distance(a.min, b.min) + glm::distance(a.max, b.max), 1e-3f * size) << name;
    ASSERT_EQ(plain.meshes.size(), compressed.meshes.size());
    for (std::size_t i = 0; i < plain.meshes.size(); ++i)
      EXPECT_EQ(plain.meshes[i]->indices.size(), compressed.meshes[i]->indices.size()) << name;
  }
}

// Rest poses that the files' own makers documented by the accessor's bounds: skinning in the bind pose moves
// nothing.
TEST(Models, TheBindPoseIsTheMesh) {
  SKIP_WITHOUT(kModels);
  const Scene scene = import_file(kModels / "SimpleSkin-Embedded.gltf");
  EXPECT_LT(glm::distance(world_bounds(scene).min, glm::vec3(-0.5f, 0, 0)), 1e-6f);
  EXPECT_LT(glm::distance(world_bounds(scene).max, glm::vec3(0.5f, 2, 0)), 1e-6f);
}

TEST(Malformed, EveryFileEndsInASceneOrAnError) {
  SKIP_WITHOUT(kMalformed);
  int files = 0;
  for (const fs::path& path : files_below(kMalformed)) {
    ++files;
    const auto error = error_of([&] { import_file(path); });
    if (!error) continue;
    EXPECT_TRUE(error->code == ErrorCode::kUnprocessable || error->code == ErrorCode::kTooLarge)
        << path << " " << error->message;
    EXPECT_FALSE(error->message.empty()) << path;
  }
  EXPECT_GT(files, 500);
}

// What the Khronos validator calls an error and this importer takes, because the picture is what the file
// means.
const std::set<std::string> kTolerated{
    // Nothing is drawn from it, or the thing is never read.
    "EMPTY_ENTITY", "ACCESSOR_INVALID_FLOAT", "UNDECLARED_EXTENSION", "DUPLICATE_ELEMENTS",
    "BUFFER_VIEW_TARGET_OVERRIDE", "SKIN_SKELETON_INVALID", "BUFFER_MISSING_GLB_DATA",
    "UNSATISFIED_DEPENDENCY", "ONE_OF_MISMATCH", "MESH_PRIMITIVE_INVALID_ATTRIBUTE",
    "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", "MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR",
    "INVALID_EXTENSION_NAME_FORMAT", "NON_REQUIRED_EXTENSION", "UNEXPECTED_EXTENSION_OBJECT",
    // Bounds are found from the data.
    "ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND", "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "ACCESSOR_MIN_MISMATCH",
    "ACCESSOR_MAX_MISMATCH", "MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS",
    // The data say how they lie all the same.
    "MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", "SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE",
    "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE", "BUFFER_VIEW_INVALID_BYTE_STRIDE", "BUFFER_DATA_URI_MIME_TYPE_INVALID",
    "INVALID_JSON",
    // Mended or left out, with a note where it is drawn.
    "ACCESSOR_VECTOR3_NON_UNIT", "ACCESSOR_INVALID_SIGN", "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS",
    "NODE_SKIN_WITH_NON_SKINNED_MESH", "MESH_PRIMITIVE_NO_POSITION", "IO_ERROR", "IMAGE_UNEXPECTED_EOS",
    "IMAGE_MIME_TYPE_INVALID", "TEXTURE_INVALID_IMAGE_MIME_TYPE", "INVALID_URI",
    "MESH_PRIMITIVE_GENERATED_TANGENT_SPACE"};

// Things of unsupported extensions and of animations are not read; nor are lengths of 0 worth a refusal.
bool is_tolerated(const std::string& code, const std::string& pointer) {
  return kTolerated.contains(code) || pointer.starts_with("/animations") ||
         pointer.find("/extensions") != std::string::npos ||
         (code == "VALUE_NOT_IN_RANGE" &&
          (pointer.ends_with("Length") || pointer.starts_with("/materials"))) ||
         (code == "UNRESOLVED_REFERENCE" && pointer.ends_with("/skeleton"));
}

// Files that test meshes often show none: this draws them all.
Blob with_every_mesh_shown(const Blob& document) {
  const Json parsed = Json::parse(document.text(), nullptr, false);
  if (!parsed.is_object() || parsed.contains("nodes") || !parsed.contains("meshes")) return document;
  Json json = parsed;
  for (std::size_t i = 0; i < parsed["meshes"].size(); ++i) json["nodes"].push_back({{"mesh", i}});
  json.erase("scenes");
  json.erase("scene");
  return Blob(json.dump());
}

TEST(Malformed, TheValidatorsErrorsAreRefusedOrTolerated) {
  SKIP_WITHOUT(kMalformed / "gltf-validator");
  int refused = 0, accepted = 0;
  for (const fs::path& path : files_below(kMalformed / "gltf-validator")) {
    if (!is_model(path)) continue;
    const Json report = Json::parse(load(path.string() + ".report.json").text());
    std::string grave;
    for (const Json& message : report["issues"]["messages"]) {
      const std::string code = message["code"], pointer = message.value("pointer", "");
      if (message["severity"] == 0 && !is_tolerated(code, pointer)) grave += " " + code + " " + pointer;
    }
    const auto error =
        error_of([&] { import_document(with_every_mesh_shown(load(path)), path.parent_path()); });
    ++(error ? refused : accepted);
    EXPECT_TRUE(error || grave.empty()) << path << grave;
    // It only warns of buffers that are not there.
    if (error && report["issues"]["numErrors"] == 0 && !error->pointer.starts_with("/buffers/")) {
      ADD_FAILURE() << path << " " << error->pointer << " " << error->message;
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(accepted, 50);
}

}  // namespace
}  // namespace furnace::testing
