// What a document's scene is imported from, at any time of its animations. Only gltf_import.cpp and gltf_model.cpp include this.
#pragma once

#include <map>
#include <utility>

#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/gltf_primitive.hpp"
#include "renderer/scene/gltf_read.hpp"

namespace furnace {

// Also of what is not drawn: all that can be checked without the bytes of any buffer. Errors: as read_gltf_document, kUnprocessable.
GltfDocument read_checked_gltf(const GltfJson& json, const ImportLimits& limits);

struct GltfModel::State {
  State(Decoder& decoder, const ModelBundle& bundle, const ImportLimits& limits, const Deadline& deadline,
        Times times);

  // As read_primitive_vertices, which a model of several times does once for what deforms.
  GltfVertices vertices_of(const GltfPrimitiveRef& ref, bool with_influences, GltfNotes& notes);

  const ModelBundle& bundle;
  const ImportLimits& limits;
  const Deadline& deadline;
  const Times times;
  const GltfJson json;
  const GltfDocument document;                          // at rest
  const std::map<std::string, std::string> undeclared;  // as undeclared_extensions()
  const GltfData data;
  std::map<ContentHash, std::map<int, SharedMesh>> meshes;             // by source_of() and tangent_set_of()
  std::map<std::pair<GltfPrimitiveRef, bool>, GltfVertices> vertices;  // with influences or without
};

}  // namespace furnace
