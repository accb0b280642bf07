// What stands in the place of plain accessors and views: compressed meshes.
#include <limits>

#include "renderer/scene/gltf_read.hpp"
#include "renderer/scene/gltf_topology.hpp"

namespace furnace {

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
