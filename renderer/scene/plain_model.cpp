#include "renderer/scene/plain_model.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/scene/scene.hpp"

namespace furnace {
namespace {

bool is_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

template <class Vector>
std::span<const float> floats_of(const std::vector<Vector>& values) {
  return {reinterpret_cast<const float*>(values.data()), values.size() * sizeof(Vector) / sizeof(float)};
}

bool is_share(float value) {
  return value >= 0 && value <= 1;
}

bool is_attribute(std::size_t values, const PlainModel& model) {
  return values == 0 || values == model.positions.size();
}

bool is_text(const TextRange& range, const PlainModel& model) {
  return std::uint64_t{range.first} + range.size <= model.text.size();
}

bool is_material(const PlainMaterial& m, const PlainModel& model) {
  bool sound = is_text(m.name, model);
  for (int i = 0; i < 3; ++i) {
    sound = sound && is_share(m.diffuse[i]) && std::isfinite(m.emission[i]) && m.emission[i] >= 0;
  }
  sound = sound && is_share(m.opacity) && m.exponent >= 0 && std::isfinite(m.exponent);
  sound = sound && m.metallic <= 1 && m.perceptual_roughness <= 1;
  sound = sound && is_share(m.clearcoat) && is_share(m.clearcoat_perceptual_roughness);
  return sound &&
         std::ranges::all_of(m.textures, [&](const TextRange& range) { return is_text(range, model); });
}

bool is_part(const PlainPart& part, const PlainModel& model) {
  const bool flags =
      part.has_normals <= 1 && part.has_uvs <= 1 && part.has_colors <= 1 && part.made_normals <= 1;
  const bool arrays = (part.has_normals == 0 || !model.normals.empty()) &&
                      (part.has_uvs == 0 || !model.uvs.empty()) &&
                      (part.has_colors == 0 || !model.colors.empty());
  return flags && arrays && is_text(part.name, model) &&
         part.topology <= std::uint32_t(Topology::kTriangles) && part.material < model.materials.size() &&
         part.indices > 0 && part.indices % (part.topology + 1) == 0;
}

// Parts fill the arrays exactly; normals that a part has are unit, within the rounding of single precision.
bool are_parts(const PlainModel& model, std::uint64_t& elements) {
  constexpr float kUnitSlack = 1e-3f;
  std::uint64_t vertex = 0, index = 0;
  for (const PlainPart& part : model.parts) {
    if (!is_part(part, model)) return false;
    const std::uint64_t vertices_end = vertex + part.vertices, indices_end = index + part.indices;
    if (vertices_end > model.positions.size() || indices_end > model.indices.size()) return false;
    for (; index < indices_end; ++index)
      if (model.indices[index] >= part.vertices) return false;
    for (; vertex < vertices_end; ++vertex)
      if (part.has_normals == 1 && !(std::abs(glm::length(model.normals[vertex]) - 1) < kUnitSlack))
        return false;
    elements += part.indices / (part.topology + 1);
  }
  return vertex == model.positions.size() && index == model.indices.size();
}

}  // namespace

bool is_sound(const PlainModel& model, const PlainModelLimits& limits) {
  const auto most = std::uint64_t(limits.max_materials);
  if (model.materials.size() > most || model.parts.size() > most || model.parts.empty()) return false;
  if (model.positions.size() > std::uint64_t(limits.max_vertices)) return false;
  if (!is_attribute(model.normals.size(), model) || !is_attribute(model.uvs.size(), model)) return false;
  if (!is_attribute(model.colors.size(), model)) return false;
  if (!is_finite(floats_of(model.positions)) || !is_finite(floats_of(model.uvs))) return false;
  if (!std::ranges::all_of(floats_of(model.colors), is_share)) return false;
  if (!std::ranges::all_of(model.materials,
                           [&](const auto& material) { return is_material(material, model); }))
    return false;
  std::uint64_t elements = 0;
  return are_parts(model, elements) && elements <= std::uint64_t(limits.max_elements);
}

}  // namespace furnace
