#include "renderer/scene/gltf_instances.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/gtc/quaternion.hpp>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

struct Attribute {
  const char* semantic;
  ElementType type;
  bool may_be_normalized;  // signed bytes and shorts
};

constexpr Attribute kAttributes[] = {
    {"TRANSLATION", ElementType::kVec3, false},
    {"ROTATION", ElementType::kVec4, true},
    {"SCALE", ElementType::kVec3, false},
};

void check_format(const GltfAccessor& accessor, const Attribute& attribute, const std::string& pointer) {
  const bool packed = accessor.normalized && (accessor.component == ComponentType::kByte ||
                                              accessor.component == ComponentType::kShort);
  const bool sound = accessor.type == attribute.type &&
                     (accessor.component == ComponentType::kFloat || (packed && attribute.may_be_normalized));
  if (!sound)
    fail(ErrorCode::kUnprocessable, "has a type or component type that instances do not take", pointer);
}

std::vector<float> read_attribute(const GltfData& data, int accessor, const std::string& pointer) {
  std::vector<float> values = data.read_numbers(accessor);
  const bool finite =
      std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
  if (!finite) fail(ErrorCode::kUnprocessable, "has a value that is not finite", pointer);
  return values;
}

void place(const Attribute& attribute, const float* values, glm::dmat4& translation, glm::dmat4& rotation,
           glm::dmat4& scale) {
  if (attribute.type == ElementType::kVec4) {
    const glm::dquat turn(values[3], values[0], values[1], values[2]);
    if (glm::length(turn) > 1e-6) rotation = glm::mat4_cast(glm::normalize(turn));
  } else if (attribute.semantic == kAttributes[0].semantic) {
    translation[3] = glm::dvec4(values[0], values[1], values[2], 1);
  } else {
    for (int axis = 0; axis < 3; ++axis) scale[axis][axis] = double(values[axis]);
  }
}

}  // namespace

std::vector<glm::dmat4> instance_transforms(const GltfDocument& document, const GltfData& data, int index,
                                            std::int64_t most) {
  const GltfNode& node = document.nodes[std::size_t(index)];
  if (node.instances.empty()) return {glm::dmat4(1)};
  const std::string pointer =
      "/nodes/" + std::to_string(index) + "/extensions/EXT_mesh_gpu_instancing/attributes";
  const std::uint64_t count = data.accessor(node.instances.begin()->second).count;
  if (count > std::uint64_t(most))
    fail(ErrorCode::kTooLarge, "has more than " + std::to_string(most) + " instances", pointer);
  for (const auto& [semantic, accessor] : node.instances) {
    if (data.accessor(accessor).count != count)
      fail(ErrorCode::kUnprocessable, "must have as many elements as the other attributes",
           pointer + "/" + semantic);
  }

  struct Placement {
    glm::dmat4 translation{1}, rotation{1}, scale{1};
  };
  std::vector<Placement> placements(std::size_t(count), Placement{});
  for (const Attribute& attribute : kAttributes) {
    const auto found = node.instances.find(attribute.semantic);
    if (found == node.instances.end()) continue;
    const std::string at = pointer + "/" + attribute.semantic;
    check_format(data.accessor(found->second), attribute, at);
    const std::vector<float> values = read_attribute(data, found->second, at);
    const auto components = std::size_t(component_count(attribute.type));
    for (std::size_t i = 0; i < placements.size(); ++i) {
      Placement& to = placements[i];
      place(attribute, &values[i * components], to.translation, to.rotation, to.scale);
    }
  }
  std::vector<glm::dmat4> result;
  result.reserve(placements.size());
  for (const Placement& p : placements) result.push_back(p.translation * p.rotation * p.scale);
  return result;
}

}  // namespace furnace
