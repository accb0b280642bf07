// What stands in the place of plain accessors and views: compressed meshes and compressed bytes.
#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include "renderer/scene/gltf_read.hpp"
#include "renderer/scene/gltf_topology.hpp"

namespace furnace {

namespace {

constexpr std::array<std::string_view, 2> kMeshoptNames{"KHR_meshopt_compression", "EXT_meshopt_compression"};

constexpr std::array<std::pair<std::string_view, MeshoptMode>, 3> kMeshoptModes{{
    {"ATTRIBUTES", MeshoptMode::kAttributes},
    {"TRIANGLES", MeshoptMode::kTriangles},
    {"INDICES", MeshoptMode::kIndices},
}};

constexpr std::array<std::pair<std::string_view, MeshoptFilter>, 5> kMeshoptFilters{{
    {"NONE", MeshoptFilter::kNone},
    {"OCTAHEDRAL", MeshoptFilter::kOctahedral},
    {"QUATERNION", MeshoptFilter::kQuaternion},
    {"EXPONENTIAL", MeshoptFilter::kExponential},
    {"COLOR", MeshoptFilter::kColor},
}};

template <class T, std::size_t N>
T named(const JsonObject& json, std::string_view key, const std::string& name,
        const std::array<std::pair<std::string_view, T>, N>& known) {
  for (const auto& [text, value] : known) {
    if (text == name) return value;
  }
  json.refuse(key, "is none that the extension has");
}

std::optional<JsonObject> meshopt_of(const JsonObject& owner) {
  for (const std::string_view name : kMeshoptNames) {
    if (auto json = owner.extension(name)) return json;
  }
  return std::nullopt;
}

}  // namespace

bool is_meshopt_fallback(const JsonObject& buffer) {
  const auto json = meshopt_of(buffer);
  return json && json->boolean("fallback", false);
}

std::optional<GltfMeshopt> read_meshopt(const JsonObject& view, const GltfBufferView& plain,
                                        const std::vector<GltfBuffer>& buffers) {
  const auto json = meshopt_of(view);
  if (!json) return std::nullopt;
  GltfMeshopt meshopt;
  meshopt.pointer = json->pointer();
  meshopt.buffer = json->required_reference("buffer", "buffer", static_cast<int>(buffers.size()));
  meshopt.byte_offset = json->integer("byteOffset", 0);
  meshopt.byte_length = json->required_integer("byteLength");
  const std::uint64_t bytes = buffers[static_cast<std::size_t>(meshopt.buffer)].byte_length;
  if (meshopt.byte_offset > bytes || meshopt.byte_length > bytes - meshopt.byte_offset) {
    json->refuse("byteLength", "reaches beyond the buffer's " + std::to_string(bytes) + " bytes");
  }
  MeshoptLayout& layout = meshopt.layout;
  layout.mode = named(*json, "mode", json->required_string("mode"), kMeshoptModes);
  layout.filter = named(*json, "filter", json->string("filter", "NONE"), kMeshoptFilters);
  layout.count = json->required_integer("count");
  layout.stride = json->required_integer("byteStride");
  if (const char* fault = meshopt_fault(layout)) fail(ErrorCode::kUnprocessable, fault, json->pointer());
  if (layout.count != plain.byte_length / layout.stride || plain.byte_length % layout.stride != 0) {
    json->refuse("count", "and byteStride do not make the bufferView's byteLength");
  }
  return meshopt;
}

std::optional<GltfDraco> read_draco(const JsonObject& primitive, const GltfAttributes& attributes, int mode,
                                    const GltfCounts& counts) {
  const auto json = primitive.extension("KHR_draco_mesh_compression");
  if (!json) return std::nullopt;
  constexpr int kTriangles = 4, kTriangleStrip = 5;
  if (mode != kTriangles && mode != kTriangleStrip) {
    primitive.refuse("mode", "must be 4 or 5 (triangles) beside KHR_draco_mesh_compression");
  }
  if (!primitive.has("indices"))
    fail(ErrorCode::kUnprocessable, "has no indices beside KHR_draco_mesh_compression", primitive.pointer());
  GltfDraco draco;
  draco.buffer_view = json->required_reference("bufferView", "bufferView", counts.buffer_views);
  const JsonObject ids = json->required_object("attributes");
  for (const std::string& semantic : ids.keys()) {
    if (!attributes.contains(semantic)) ids.refuse(semantic, "is no attribute of the primitive");
    const std::uint64_t id = ids.required_integer(semantic);
    if (id > std::numeric_limits<std::uint32_t>::max()) ids.refuse(semantic, "is too large");
    draco.attributes[semantic] = static_cast<std::uint32_t>(id);
  }
  return draco;
}

}  // namespace furnace
