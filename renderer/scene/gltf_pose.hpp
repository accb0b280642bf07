// Where everything stands in the rest pose: world transforms of nodes, joints and cameras, in double
// precision.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_notes.hpp"

namespace furnace {

// world_from_node of every node. Errors: kUnprocessable for a transform that leaves single precision.
std::vector<glm::dmat4> world_transforms(const GltfDocument& document, GltfNotes& notes);

// world_from_bind of every joint: world_from_joint * inverse bind matrix. Errors: kUnprocessable for matrices
// that are too few, of a wrong type or not finite.
std::vector<glm::dmat4> skin_transforms(const GltfDocument& document, const GltfData& data, int skin,
                                        const std::vector<glm::dmat4>& world_from_node);
void check_skin(const GltfDocument& document, int skin);

// The rotation and place of a node without its scale, as glTF 2.0, section 3.10, wants cameras.
glm::mat4 camera_transform(const glm::dmat4& world_from_node);

}  // namespace furnace
