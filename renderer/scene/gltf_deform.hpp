// The rest pose on the CPU: morph targets at their default weights, then skins, in double precision.
#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/gltf_primitive.hpp"

namespace furnace {

// Adds every target whose weight is not 0 to the attributes that the primitive itself has. `weights` may be
// shorter than the targets: the rest are 0. Errors: kUnprocessable for a displacement that is not finite.
void apply_morph_targets(const GltfDocument& document, const GltfData& data, const GltfPrimitiveRef& ref,
                         std::span<const double> weights, Mesh& mesh, GltfNotes& notes);

// Takes positions, normals and tangents to the space of `world_from_bind`, one matrix per joint. Weights are
// normalised. When the joints mirror, windings and tangent signs are turned, since no instance transform is
// left to tell. Errors: kUnprocessable for a joint that is out of range or a weight that is not finite.
void apply_skin(GltfVertices& vertices, std::span<const glm::dmat4> world_from_bind,
                const std::string& pointer, GltfNotes& notes);

}  // namespace furnace
