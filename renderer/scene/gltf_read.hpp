// The parts of reading a glTF document, one function per kind of object; gltf_document.cpp puts them
// together.
#pragma once

#include "renderer/scene/gltf_document.hpp"
#include "renderer/scene/gltf_json.hpp"

namespace furnace {

// Lengths of the document's arrays, known before any of them is read: what an index is checked against.
struct GltfCounts {
  int buffers, buffer_views, accessors, images, samplers, textures, materials, meshes, skins, cameras, nodes,
      scenes, lights, variants;
};

// A document before its values are read.
struct GltfJson {
  Json root;
  std::optional<ByteRange> binary;  // as GltfDocument::binary
};

// gltf_document.cpp. Errors: as read_gltf_document.
GltfJson parse_gltf(const Blob& bytes, const ImportLimits& limits);
GltfDocument read_gltf_document(const GltfJson& json, const ImportLimits& limits);

// gltf_extensions.cpp: what extension objects there are that are neither supported nor in extensionsUsed, each with the
// place of the first; as many as a report has room for.
inline constexpr std::size_t kMostUndeclared = 1000;
std::map<std::string, std::string> undeclared_extensions(const Json& root);

// gltf_read_data.cpp
GltfBuffer read_buffer(const JsonObject& json);
GltfBufferView read_buffer_view(const JsonObject& json, const std::vector<GltfBuffer>& buffers);
// Checks the accessor's bytes, and its sparse ones, against their views.
GltfAccessor read_accessor(const JsonObject& json, const std::vector<GltfBufferView>& views);

// gltf_read_material.cpp
GltfImage read_image(const JsonObject& json, const GltfCounts& counts);
SamplerDesc read_sampler(const JsonObject& json);
GltfTexture read_texture(const JsonObject& json, const GltfCounts& counts,
                         const std::vector<SamplerDesc>& samplers);
GltfMaterial read_material(const JsonObject& json, const GltfCounts& counts);

// gltf_read_compression.cpp
bool is_meshopt_fallback(const JsonObject& buffer);
std::optional<GltfMeshopt> read_meshopt(const JsonObject& view, const GltfBufferView& plain,
                                        const std::vector<GltfBuffer>& buffers);
// Errors: kUnprocessable for an attribute that the primitive itself does not have, and for lines and points.
std::optional<GltfDraco> read_draco(const JsonObject& primitive, const GltfAttributes& attributes, int mode,
                                    const GltfCounts& counts);

// gltf_read_scene.cpp
GltfMesh read_mesh(const JsonObject& json, const GltfCounts& counts);
GltfSkin read_skin(const JsonObject& json, const GltfCounts& counts);
CameraNode read_camera(const JsonObject& json);
std::optional<Light> read_light(const JsonObject& json, std::vector<Note>& notes);
GltfNode read_node(const JsonObject& json, const GltfCounts& counts);
// Sets every node's parent. Errors: two parents, a cycle, a depth over the limit.
void link_nodes(std::vector<GltfNode>& nodes, const ImportLimits& limits);
// gltf_read_animation.cpp
GltfAnimation read_animation(const JsonObject& json, const GltfCounts& counts);

GltfScene read_scene(const JsonObject& json, const std::vector<GltfNode>& nodes);

}  // namespace furnace
