// Small glTF documents for tests, their one buffer beside them as "data.bin".
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "renderer/base/error.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/scene/gltf_import.hpp"

namespace furnace::testing {

using Json = nlohmann::json;

template <class T>
constexpr int component_code() {
  if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
  if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
  if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
  return 5126;
}

inline int components_of(const std::string& type) {
  static const std::map<std::string, int> counts{
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
  return counts.at(type);
}

struct GltfBuilder {
  Json json = {{"asset", {{"version", "2.0"}}}};
  std::string bytes;

  // Appends to an array of the document; returns the index.
  int add(const std::string& array, Json object) {
    json[array].push_back(std::move(object));
    return static_cast<int>(json[array].size()) - 1;
  }

  template <class T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    Json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}};
    if (stride != 0) view["byteStride"] = stride;
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return add("bufferViews", view);
  }

  template <class T>
  int add_accessor(const std::string& type, const std::vector<T>& values, bool normalized = false) {
    Json accessor = {{"bufferView", add_view(values)},
                     {"type", type},
                     {"componentType", component_code<T>()},
                     {"count", values.size() / static_cast<std::size_t>(components_of(type))}};
    if (normalized) accessor["normalized"] = true;
    return add("accessors", accessor);
  }

  // One node that shows one mesh of one primitive.
  void show(Json primitive, Json node = Json::object()) {
    node["mesh"] = add("meshes", {{"primitives", Json::array({std::move(primitive)})}});
    add("nodes", std::move(node));
  }

  ModelBundle bundle() const {
    Json document = json;
    if (!bytes.empty())
      document["buffers"] = Json::array({{{"byteLength", bytes.size()}, {"uri", "data.bin"}}});
    ModelBundle result;
    result.document = Blob(document.dump());
    result.siblings["data.bin"] = Blob(bytes);
    result.seal();
    return result;
  }

  Scene import(const ImportOptions& options = {}, const ImportLimits& limits = {}) const {
    return import_gltf(decode::in_process_decoder(), bundle(), options, limits, Deadline());
  }
};

// A right triangle in the plane z = 0, counter-clockwise seen from +z.
inline GltfBuilder triangle_builder() {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  builder.show({{"attributes", {{"POSITION", position}}}});
  return builder;
}

// A triangle with normals and both UV sets: nothing to mend.
inline GltfBuilder clean_builder(Json node = Json::object()) {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int normal = builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv0 = builder.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  const int uv1 = builder.add_accessor<float>("VEC2", {0.5f, 0, 1, 0, 0, 1});
  builder.show({{"attributes",
                 {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv0}, {"TEXCOORD_1", uv1}}}},
               std::move(node));
  return builder;
}

inline Json& primitive_of(GltfBuilder& builder) {
  return builder.json["meshes"][0]["primitives"][0];
}

// Enough of a PNG to be taken for one: importing does not decode.
inline const std::string kPngStart("\x89PNG\r\n\x1a\n", 8);

inline int add_texture(GltfBuilder& builder, const std::string& uri) {
  return builder.add("textures", {{"source", builder.add("images", {{"uri", uri}})}});
}

inline Scene import_with_png(const GltfBuilder& builder, const std::string& name) {
  ModelBundle bundle = builder.bundle();
  bundle.siblings[name] = Blob(kPngStart);
  return import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
}

// The Error that `body` ends with, if any.
template <class Body>
std::optional<Error> error_of(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

inline std::string pointer_of_error(const GltfBuilder& builder, const ImportLimits& limits = {}) {
  const auto error = error_of([&] { builder.import({}, limits); });
  return error ? error->pointer : "no error";
}

inline std::vector<std::string> note_codes(const Scene& scene) {
  std::vector<std::string> codes;
  for (const Note& note : scene.notes) codes.push_back(note.code);
  return codes;
}

inline const Note* find_note(const Scene& scene, const std::string& code) {
  for (const Note& note : scene.notes) {
    if (note.code == code) return &note;
  }
  return nullptr;
}

}  // namespace furnace::testing
