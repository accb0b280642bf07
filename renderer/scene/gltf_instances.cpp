#include "renderer/scene/gltf_instances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
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

glm::dmat4 turned(const float* xyzw) {
  const glm::dquat turn(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  return glm::length(turn) > 1e-6 ? glm::mat4_cast(glm::normalize(turn)) : glm::dmat4(1);
}

}  // namespace

std::vector<glm::dmat4> instance_transforms(const GltfDocument& document, const GltfData& data, int index,
                                            std::int64_t others, std::int64_t most) {
  const GltfNode& node = document.nodes[std::size_t(index)];
  if (node.instances.empty()) return {glm::dmat4(1)};
  const std::string pointer =
      "/nodes/" + std::to_string(index) + "/extensions/EXT_mesh_gpu_instancing/attributes";
  const std::uint64_t count = data.accessor(node.instances.begin()->second).count;
  if (count > std::uint64_t(most - others))
    fail(ErrorCode::kTooLarge, "the scene has more than " + std::to_string(most) + " instances", pointer);
  for (const auto& [semantic, accessor] : node.instances) {
    if (data.accessor(accessor).count != count)
      fail(ErrorCode::kUnprocessable, "must have as many elements as the other attributes",
           pointer + "/" + semantic);
  }

  std::array<std::vector<float>, std::size(kAttributes)> values;
  for (std::size_t a = 0; a < values.size(); ++a) {
    const auto found = node.instances.find(kAttributes[a].semantic);
    if (found == node.instances.end()) continue;
    const std::string at = pointer + "/" + kAttributes[a].semantic;
    check_format(data.accessor(found->second), kAttributes[a], at);
    values[a] = read_attribute(data, found->second, at);
  }
  const auto& [translations, rotations, scales] = values;
  std::vector<glm::dmat4> result(std::size_t(count), glm::dmat4(1));
  for (std::size_t i = 0; i < result.size(); ++i) {
    glm::dmat4& place = result[i];
    if (!rotations.empty()) place = turned(&rotations[i * 4]);
    if (!scales.empty())
      for (int axis = 0; axis < 3; ++axis) place[axis] *= double(scales[i * 3 + std::size_t(axis)]);
    if (!translations.empty())
      place[3] = glm::dvec4(translations[i * 3], translations[i * 3 + 1], translations[i * 3 + 2], 1);
  }
  return result;
}

}  // namespace furnace
