#include "renderer/scene/gltf_pose.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

constexpr double kLargest = 1e30;  // leaves single precision room for products with positions

bool is_bounded(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!(std::abs(m[column][row]) < kLargest)) return false;
    }
  }
  return true;
}

glm::dmat4 parent_from_node(const GltfNode& node, std::size_t index, GltfNotes& notes) {
  if (node.matrix) return *node.matrix;
  if (std::abs(glm::length(node.rotation) - 1) > 0.01) {
    notes.add("rotation-repaired", "/nodes/" + std::to_string(index) + "/rotation",
              "is not a unit quaternion and was normalised");
  }
  glm::dmat4 result = glm::mat4_cast(glm::normalize(node.rotation));
  for (int axis = 0; axis < 3; ++axis) result[axis] *= node.scale[axis];
  result[3] = glm::dvec4(node.translation, 1);
  return result;
}

}  // namespace

std::vector<glm::dmat4> world_transforms(const GltfDocument& document, GltfNotes& notes) {
  std::vector<glm::dmat4> world(document.nodes.size());
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < document.nodes.size(); ++i) {
    if (document.nodes[i].parent < 0) open.push_back(i);
  }
  while (!open.empty()) {
    const std::size_t index = open.back();
    open.pop_back();
    const GltfNode& node = document.nodes[index];
    world[index] = parent_from_node(node, index, notes);
    if (node.parent >= 0) world[index] = world[static_cast<std::size_t>(node.parent)] * world[index];
    if (!is_bounded(world[index])) {
      fail(ErrorCode::kUnprocessable, "has a transform that leaves single precision",
           "/nodes/" + std::to_string(index));
    }
    for (const int child : node.children) open.push_back(static_cast<std::size_t>(child));
  }
  return world;
}

void check_skin(const GltfDocument& document, int index) {
  const GltfSkin& skin = document.skins[static_cast<std::size_t>(index)];
  if (!skin.inverse_bind_matrices) return;
  const GltfAccessor& accessor = document.accessors[static_cast<std::size_t>(*skin.inverse_bind_matrices)];
  const std::string pointer = "/skins/" + std::to_string(index) + "/inverseBindMatrices";
  if (accessor.type != ElementType::kMat4 || accessor.component != ComponentType::kFloat) {
    fail(ErrorCode::kUnprocessable, "must be an accessor of MAT4 floats", pointer);
  }
  if (accessor.count < skin.joints.size()) {
    fail(ErrorCode::kUnprocessable,
         "has " + std::to_string(accessor.count) + " matrices for " + std::to_string(skin.joints.size()) +
             " joints",
         pointer);
  }
}

std::vector<glm::dmat4> skin_transforms(const GltfDocument& document, const GltfData& data, int index,
                                        const std::vector<glm::dmat4>& world_from_node) {
  const GltfSkin& skin = document.skins[static_cast<std::size_t>(index)];
  std::vector<glm::dmat4> result;
  for (const int joint : skin.joints) result.push_back(world_from_node[static_cast<std::size_t>(joint)]);
  if (!skin.inverse_bind_matrices) return result;
  const std::vector<glm::mat4> joint_from_bind = data.read_matrices(*skin.inverse_bind_matrices);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = result[i] * glm::dmat4(joint_from_bind[i]);
    if (!is_bounded(result[i])) {
      fail(ErrorCode::kUnprocessable,
           "matrix " + std::to_string(i) + " is not finite or leaves single precision",
           "/skins/" + std::to_string(index) + "/inverseBindMatrices");
    }
  }
  return result;
}

glm::mat4 camera_transform(const glm::dmat4& world_from_node) {
  const auto unit_or = [](const glm::dvec3& v, const glm::dvec3& otherwise) {
    const double length = glm::length(v);
    return length > 1e-12 ? v / length : otherwise;
  };
  const glm::dmat3 linear(world_from_node);
  const glm::dvec3 back = unit_or(linear[2], {0, 0, 1});
  const glm::dvec3 other = std::abs(back.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = unit_or(glm::cross(linear[1], back), glm::normalize(glm::cross(other, back)));
  glm::dmat4 result(1);
  result[0] = glm::dvec4(right, 0);
  result[1] = glm::dvec4(glm::cross(back, right), 0);
  result[2] = glm::dvec4(back, 0);
  result[3] = world_from_node[3];
  return glm::mat4(result);
}

}  // namespace furnace
