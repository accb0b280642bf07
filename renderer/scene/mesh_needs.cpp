#include "renderer/scene/mesh_needs.hpp"

#include "renderer/scene/tangents.hpp"

namespace furnace {

std::optional<int> tangent_uv_set(const Material& material) {
  for (const TextureUse use : {TextureUse::kNormal, TextureUse::kClearcoatNormal})
    if (const auto& slot = material.texture(use)) return slot->uv_set;
  if (!(material.anisotropy > 0)) return std::nullopt;
  const auto& slot = material.texture(TextureUse::kAnisotropy);
  return slot ? slot->uv_set : 0;
}

bool is_complete(const Mesh& mesh, const Material& material) {
  for (const auto& slot : material.textures)
    if (slot && mesh.uvs[std::size_t(slot->uv_set)].empty()) return false;
  return !tangent_uv_set(material) || !mesh.tangents.empty() || mesh.topology != Topology::kTriangles;
}

std::vector<int> fill_uv_sets(Mesh& mesh, const Material& material) {
  std::vector<int> filled;
  const auto need = [&](int uv_set) {
    auto& uvs = mesh.uvs[std::size_t(uv_set)];
    if (!uvs.empty()) return;
    uvs.assign(mesh.positions.size(), glm::vec2(0));
    filled.push_back(uv_set);
  };
  for (const auto& slot : material.textures)
    if (slot) need(slot->uv_set);
  if (const auto uv_set = tangent_uv_set(material);
      uv_set && mesh.tangents.empty() && mesh.topology == Topology::kTriangles)
    need(*uv_set);
  return filled;
}

bool make_tangents(Mesh& mesh, const Material& material) {
  const auto uv_set = tangent_uv_set(material);
  if (!uv_set || !mesh.tangents.empty() || mesh.topology != Topology::kTriangles) return false;
  generate_tangents(mesh, *uv_set);
  return true;
}

}  // namespace furnace
