#include "renderer/scene/gltf_draco.hpp"

#include <utility>

#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_topology.hpp"

namespace furnace {

namespace {

// Application-specific ones may be matrices, and are never read.
bool is_read(const std::string& semantic, const GltfAccessor& accessor) {
  return !semantic.starts_with('_') && accessor.type <= ElementType::kVec4;
}

}  // namespace

DecodedPrimitive decode_primitive(const GltfDocument& document, const GltfData& data,
                                  const GltfPrimitiveRef& ref) {
  const GltfPrimitive& primitive = primitive_of(document, ref);
  DecodedPrimitive result;
  if (!primitive.draco) return result;
  DracoRequest request;
  request.vertices = data.accessor(primitive.attributes.at("POSITION")).count;
  request.most_triangles = element_count(primitive.mode, data.accessor(*primitive.indices).count);
  std::vector<std::string> semantics;
  for (const auto& [semantic, id] : primitive.draco->attributes) {
    const GltfAccessor& accessor = data.accessor(primitive.attributes.at(semantic));
    if (!is_read(semantic, accessor)) continue;
    semantics.push_back(semantic);
    request.attributes.push_back(
        {id, static_cast<DracoComponent>(accessor.component), component_count(accessor.type)});
  }
  const std::string pointer = ref.pointer() + "/extensions/KHR_draco_mesh_compression";
  try {
    DracoMesh mesh = data.read_draco(primitive.draco->buffer_view, request);
    result.indices = std::move(mesh.indices);
    for (std::size_t i = 0; i < semantics.size(); ++i)
      result.attributes.emplace(semantics[i], std::move(mesh.attributes[i]));
  } catch (Error& error) {
    error.pointer = pointer;
    throw;
  }
  return result;
}

}  // namespace furnace
