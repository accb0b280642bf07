#include "renderer/residency/gpu_blocks.hpp"

#include <cmath>

namespace furnace::gpu {
namespace {

// KHR_texture_transform: translation * rotation * scale, as the two rows that meet (u, v, 1).
void pack_uv_rows(const UvTransform& t, vec4* rows) {
  const float c = std::cos(t.rotation_rad);
  const float s = std::sin(t.rotation_rad);
  rows[0] = vec4(c * t.scale.x, s * t.scale.y, t.offset.x, 0);
  rows[1] = vec4(-s * t.scale.x, c * t.scale.y, t.offset.y, 0);
}

}  // namespace

MaterialBlock pack_material(const Material& material) {
  MaterialBlock block{};
  block.base_color = material.base_color;
  if (material.alpha_mode == AlphaMode::kOpaque) block.base_color.a = 1;
  block.emissive = vec4(material.emissive * material.emissive_strength, 0);
  block.metallic = material.metallic;
  block.perceptual_roughness = material.perceptual_roughness;
  block.normal_scale = material.normal_scale;
  block.occlusion_strength = material.occlusion_strength;
  block.alpha_cutoff = material.alpha_cutoff;
  block.double_sided = material.double_sided ? 1 : 0;
  for (int i = 0; i < kSlotCount; ++i) {
    const auto& slot = material.*kMaterialSlots[i];
    pack_uv_rows(slot ? slot->transform : UvTransform{}, &block.uv_rows[2 * i]);
    if (slot && slot->uv_set == 1) block.uv_sets |= 1u << i;
  }
  return block;
}

DrawBlock pack_draw(const glm::mat4& world_from_model, uint key, uint vertex_rows) {
  DrawBlock block{};
  const glm::mat3 linear(world_from_model);
  const float determinant = glm::determinant(linear);
  block.world_from_model = world_from_model;
  block.handedness = determinant < 0 ? -1.f : 1.f;
  block.key = key;
  block.vertex_rows = vertex_rows;
  // The cofactor matrix is the inverse transpose times the determinant: finite for flattened nodes too.
  const glm::mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                           glm::cross(linear[0], linear[1]));
  block.world_from_model_normal = glm::mat4(cofactor * block.handedness);
  return block;
}

}  // namespace furnace::gpu
