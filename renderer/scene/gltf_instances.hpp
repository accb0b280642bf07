// EXT_mesh_gpu_instancing: a node's mesh at many places.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/gltf_accessor.hpp"

namespace furnace {

// node_from_instance of each instance; one identity for a node without the extension. Errors: kUnprocessable for accessors of a
// wrong type or of different lengths and for values that are not finite, kTooLarge for more than `most`
// together with the `others` that the scene has already.
std::vector<glm::dmat4> instance_transforms(const GltfDocument& document, const GltfData& data, int node,
                                            std::int64_t others, std::int64_t most);

}  // namespace furnace
