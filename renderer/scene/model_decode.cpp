#include "renderer/scene/plain_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/model_builder.hpp"
#include "renderer/scene/mtl_text.hpp"
#include "renderer/scene/obj_vertices.hpp"
#include "renderer/scene/ply_decode.hpp"
#include "renderer/scene/stl_decode.hpp"
#include "renderer/scene/text_lines.hpp"

namespace furnace {
namespace {

using Bytes = std::span<const std::byte>;

// Files of a model that is in memory: the document, and all MTL files as one under whichever name is asked for first.
// Threads: one. Owns: nothing.
class MemoryFiles : public Assimp::IOSystem {
 public:
  MemoryFiles(std::string document_name, Bytes document, Bytes materials)
      : document_name_(std::move(document_name)), document_(document), materials_(materials) {}

  bool Exists(const char* name) const override { return name == document_name_ || !materials_.empty(); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char*) override {
    if (name == document_name_) return stream_of(document_);
    if (materials_.empty()) return nullptr;
    return stream_of(std::exchange(materials_, {}));
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  static Assimp::IOStream* stream_of(Bytes bytes) {
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }

  std::string document_name_;
  Bytes document_, materials_;
};

// Before anything walks along them: the library's own steps take indices on trust.
void check_faces(const aiScene& scene, const PlainModelLimits& limits) {
  // Cutting a polygon up takes the square of its corners.
  constexpr unsigned kMostCorners = 4096;
  std::int64_t vertices = 0, corners = 0;
  if (scene.mNumMeshes > limits.max_materials) fail_too_many(limits.max_materials, "parts");
  if (scene.mNumMaterials > limits.max_materials) fail_too_many(limits.max_materials, "materials");
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    vertices += mesh.mNumVertices;
    if (mesh.mMaterialIndex >= scene.mNumMaterials)
      fail(ErrorCode::kUnprocessable, "names a material that is not there");
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      corners += face.mNumIndices;
      if (face.mNumIndices > kMostCorners) fail_too_many(kMostCorners, "corners in one polygon");
      for (unsigned i = 0; i < face.mNumIndices; ++i)
        if (face.mIndices[i] >= mesh.mNumVertices)
          fail(ErrorCode::kUnprocessable,
               fmt::format("a face names vertex {} of {}", face.mIndices[i], mesh.mNumVertices));
    }
  }
  // Corners are split before equal ones are joined.
  const std::int64_t most = 3 * std::max(limits.max_vertices, limits.max_elements);
  if (vertices > most || corners > most) fail_too_many(limits.max_vertices, "vertices");
}

glm::vec3 vector_of(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

// Some write colours of vertices as bytes.
void bring_colors_to_one(std::span<glm::vec4> colors) {
  const auto exceeds = [](const glm::vec4& c) { return std::max({c.r, c.g, c.b}) > 1; };
  if (std::ranges::none_of(colors, exceeds)) return;
  for (glm::vec4& c : colors) c = glm::vec4(glm::vec3(c) / 255.0f, c.a);
}

// The faces of one topology, with the whole mesh's vertices.
Mesh mesh_of(const aiMesh& from, Topology topology) {
  const unsigned corners = unsigned(topology) + 1;
  Mesh mesh;
  mesh.topology = topology;
  mesh.name = from.mName.C_Str();
  for (unsigned f = 0; f < from.mNumFaces; ++f) {
    const aiFace& face = from.mFaces[f];
    if (face.mNumIndices != corners) continue;
    const unsigned* i = face.mIndices;
    const bool degenerate = (corners > 1 && i[0] == i[1]) || (corners > 2 && (i[1] == i[2] || i[0] == i[2]));
    if (!degenerate) mesh.indices.insert(mesh.indices.end(), i, i + corners);
  }
  if (mesh.indices.empty()) return mesh;

  for (unsigned i = 0; i < from.mNumVertices; ++i) mesh.positions.push_back(vector_of(from.mVertices[i]));
  if (from.HasNormals())
    for (unsigned i = 0; i < from.mNumVertices; ++i) mesh.normals.push_back(vector_of(from.mNormals[i]));
  if (from.HasTextureCoords(0))
    for (unsigned i = 0; i < from.mNumVertices; ++i)
      mesh.uvs[0].emplace_back(from.mTextureCoords[0][i].x, 1 - from.mTextureCoords[0][i].y);
  // The library's lines carry the colours of other vertices.
  if (from.HasVertexColors(0) && topology != Topology::kLines)
    for (unsigned i = 0; i < from.mNumVertices; ++i) {
      const aiColor4D& c = from.mColors[0][i];
      mesh.colors.emplace_back(c.r, c.g, c.b, c.a);
    }
  bring_colors_to_one(mesh.colors);
  return mesh;
}

float number_of(const aiMaterial& from, const char* key, float low, float high, float unstated) {
  float value = unstated;
  if (from.Get(key, 0, 0, value) != AI_SUCCESS || std::isnan(value)) return unstated;
  return std::clamp(value, low, high);
}

glm::vec3 color_of(const aiMaterial& from, const char* key, float high, const glm::vec3& unstated) {
  aiColor3D color;
  if (from.Get(key, 0, 0, color) != AI_SUCCESS) return unstated;
  const auto channel = [&](float value) { return value > 0 ? std::min(value, high) : 0.0f; };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

constexpr float kMostEmission = 1e6f, kMostExponent = 1e6f;

void add_textures(const aiMaterial& from, ModelBuilder& builder, PlainMaterial& to) {
  static constexpr std::array<std::pair<aiTextureType, PlainTexture>, 5> kUses = {{
      {aiTextureType_DIFFUSE, PlainTexture::kBaseColor},
      {aiTextureType_EMISSIVE, PlainTexture::kEmissive},
      {aiTextureType_NORMALS, PlainTexture::kNormal},
      {aiTextureType_HEIGHT, PlainTexture::kBump},
      {aiTextureType_OPACITY, PlainTexture::kAlpha},
  }};
  for (const auto& [type, use] : kUses) {
    aiString name;
    TextRange& range = to.textures[std::size_t(use)];
    if (range.size == 0 && from.GetTexture(type, 0, &name) == AI_SUCCESS)
      range = builder.add_text({name.C_Str(), name.length});
  }
}

void add_material(const aiMaterial& from, bool stated, ModelBuilder& builder) {
  PlainMaterial to = builder.plain_material();
  if (stated) {
    aiString name;
    if (from.Get(AI_MATKEY_NAME, name) == AI_SUCCESS) to.name = builder.add_text({name.C_Str(), name.length});
    to.diffuse = color_of(from, "$clr.diffuse", 1, to.diffuse);
    to.emission = color_of(from, "$clr.emissive", kMostEmission, to.emission);
    to.opacity = number_of(from, "$mat.opacity", 0, 1, 1);
    to.exponent = number_of(from, "$mat.shininess", 0, kMostExponent, 0);
    to.metallic = number_of(from, "$mat.metallicFactor", 0, 1, -1);
    to.perceptual_roughness = number_of(from, "$mat.roughnessFactor", 0, 1, -1);
    to.clearcoat = number_of(from, "$mat.clearcoat.factor", 0, 1, 0);
    to.clearcoat_perceptual_roughness = number_of(from, "$mat.clearcoat.roughnessFactor", 0, 1, 0);
  }
  add_textures(from, builder, to);
  builder.add_material(to);
}

void add_scene(const aiScene& scene, ModelBuilder& builder) {
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
    aiString name;
    scene.mMaterials[i]->Get(AI_MATKEY_NAME, name);
    const bool stated = std::string_view(name.C_Str()) != AI_DEFAULT_MATERIAL_NAME;
    add_material(*scene.mMaterials[i], stated, builder);
  }
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (const Topology topology : {Topology::kTriangles, Topology::kLines, Topology::kPoints})
      builder.add_part(mesh_of(mesh, topology), mesh.mMaterialIndex, false);
  }
}

// Statements before the first material are of none; the library crashes on them (assimp 5.2.5).
std::string_view from_first_material(std::string_view text) {
  constexpr std::string_view kBegin = "newmtl";
  for (std::size_t at = text.find(kBegin); at != text.npos; at = text.find(kBegin, at + 1)) {
    const std::size_t line = text.find_last_of("\r\n", at) + 1;
    if (text.substr(line, at - line).find_first_not_of(" \t") == text.npos) return text.substr(at);
  }
  return {};
}

// Whether a line begins with f, l or p: without, the library's message is of normals.
bool has_elements(std::string_view obj) {
  while (!obj.empty()) {
    std::string_view line = take_line(obj);
    const std::string_view word = take_word(line);
    if (word == "f" || word == "l" || word == "p" || word == "fo") return true;
  }
  return false;
}

void add_vertices(std::string_view obj, ModelBuilder& builder) {
  Mesh mesh;
  mesh.topology = Topology::kPoints;
  std::string joined;
  while (!obj.empty()) {
    std::string_view statement = take_statement(obj, joined);
    if (take_word(statement) != "v") continue;
    const ObjVertex vertex = obj_vertex(statement, mesh.positions.size() + 1);
    mesh.indices.push_back(std::uint32_t(mesh.positions.size()));
    mesh.positions.push_back(vertex.position);
    if (vertex.color) mesh.colors.emplace_back(*vertex.color, 1);
  }
  if (mesh.colors.size() != mesh.positions.size()) mesh.colors.clear();  // some are no numbers
  bring_colors_to_one(mesh.colors);
  builder.add_material(builder.plain_material());
  builder.add_part(std::move(mesh), 0, false);
}

[[noreturn]] void fail_as(const Assimp::Importer& importer) {
  if (importer.GetException()) std::rethrow_exception(importer.GetException());
  fail_unreadable(ModelFormat::kObj, importer.GetErrorString());
}

void add_obj(Bytes bytes, std::string_view materials, ModelBuilder& builder) {
  // By whose ending the library takes its reader, and that no line can name as its materials.
  const std::string name = "\n.obj";
  const std::string_view written = without_mark({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const std::optional<std::string> even = with_even_vertices(written);
  const std::string_view text = even ? *even : written;
  if (!has_elements(text)) {
    if (has_free_forms(text))
      fail_unreadable(ModelFormat::kObj, "it has free-form curves or surfaces alone, which are not drawn");
    return add_vertices(text, builder);
  }
  try {
    Assimp::Importer importer;
    importer.SetIOHandler(
        new MemoryFiles(name, std::as_bytes(std::span(text)),
                        std::as_bytes(std::span(from_first_material(materials)))));  // owns it
    const aiScene* scene = importer.ReadFile(name, 0);
    if (scene == nullptr) fail_as(importer);
    check_faces(*scene, builder.limits());
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    if (scene == nullptr) fail_as(importer);
    check_faces(*scene, builder.limits());
    add_scene(*scene, builder);
  } catch (const std::bad_alloc&) {
    throw;  // the process that decodes says so
  } catch (const std::exception& error) {
    fail_unreadable(ModelFormat::kObj, error.what());
  }
}

}  // namespace

PlainModel decode_model(Bytes document, std::string_view materials, ModelFormat format,
                        const PlainModelLimits& limits, const Deadline& deadline) {
  ModelBuilder builder(limits);
  switch (format) {
    case ModelFormat::kGltf:
      fail_unreadable(format, "it is read elsewhere");
    case ModelFormat::kObj:
      add_obj(document, materials, builder);
      break;
    case ModelFormat::kStl:
      add_stl(document, builder);
      break;
    case ModelFormat::kPly:
      add_ply(document, builder, deadline);
      break;
  }
  return builder.take();
}

}  // namespace furnace
