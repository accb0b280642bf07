#include "renderer/residency/gpu_blocks.hpp"

#include <algorithm>
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

// What is not seen through. Where a texture says how much that is, all of it.
float shadow_opacity(const Material& material) {
  if (material.texture(TextureUse::kTransmission)) return 1;
  constexpr float kBothSides = 0.92f;  // a pane of index of refraction 1.5 reflects the rest
  const glm::vec3 color =
      glm::vec3(material.base_color) *
      glm::pow(material.attenuation_color, glm::vec3(material.thickness_m / material.attenuation_distance_m));
  const float seen = glm::dot(color, glm::vec3(0.2126f, 0.7152f, 0.0722f));
  return 1 - kBothSides * material.transmission * (1 - material.metallic) * seen;
}

// Of as many uses from `first` on as there are rows for. Returns the bits of those that read UV set 1.
template <std::size_t N>
uint pack_uv(const Material& material, std::size_t first, vec4 (&rows)[N]) {
  uint uv_sets = 0;
  for (std::size_t i = 0; i < N / 2; ++i) {
    const auto& slot = material.textures[first + i];
    pack_uv_rows(slot ? slot->transform : UvTransform{}, &rows[2 * i]);
    if (slot && slot->uv_set == 1) uv_sets |= 1u << i;
  }
  return uv_sets;
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
  block.shadow_opacity = shadow_opacity(material);
  block.uv_sets = pack_uv(material, 0, block.uv_rows);
  return block;
}

LayerBlock pack_layers(const Material& material) {
  LayerBlock block{};
  // KHR_materials_ior: 0 stands for a surface that reflects everything.
  const float r = material.ior > 0 ? (material.ior - 1) / (material.ior + 1) : 1;
  block.specular = vec4(r * r * material.specular_color, material.specular);
  block.clearcoat =
      vec4(material.clearcoat, material.clearcoat_perceptual_roughness, material.clearcoat_normal_scale, 0);
  block.sheen = vec4(material.sheen_color, material.sheen_perceptual_roughness);
  block.anisotropy = vec4(material.anisotropy, std::cos(material.anisotropy_rotation_rad),
                          std::sin(material.anisotropy_rotation_rad), 0);
  block.iridescence = vec4(material.iridescence, material.iridescence_ior,
                           material.iridescence_thickness_min_nm, material.iridescence_thickness_max_nm);
  block.transmission = vec4(material.transmission, material.ior > 0 ? material.ior : 1, material.thickness_m,
                            material.dispersion);
  // Beer and Lambert: attenuation_color is left after attenuation_distance_m. Black is left nowhere.
  const glm::vec3 left = glm::max(material.attenuation_color, glm::vec3(1e-6f));
  block.absorption = vec4(-glm::log(left) / material.attenuation_distance_m, 0);
  block.diffuse_transmission = vec4(material.diffuse_transmission_color, material.diffuse_transmission);
  block.glossy = vec4(material.glossy_specular, material.glossiness);
  block.is_phong = material.model == ShadingModel::kPhong ? 1 : 0;
  block.uv_sets = pack_uv(material, kCoreTextures, block.uv_rows);
  return block;
}

DrawBlock pack_draw(const glm::mat4& world_from_model, uint key, uint vertex_rows) {
  DrawBlock block{};
  glm::mat3 linear(world_from_model);
  // Normals have no size: the model's, whose fourth power the shaders take, would leave single precision. By a power of
  // two, so that no digit changes.
  float largest = 0;
  for (int i = 0; i < 9; ++i) largest = std::max(largest, std::abs(linear[i / 3][i % 3]));
  if (largest > 0) linear *= std::ldexp(1.f, -std::ilogb(largest));
  block.world_from_model = world_from_model;
  block.handedness = glm::determinant(linear) < 0 ? -1.f : 1.f;
  block.key = key;
  block.vertex_rows = vertex_rows;
  // The cofactor matrix is the inverse transpose times the determinant: finite for flattened nodes too.
  const glm::mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                           glm::cross(linear[0], linear[1]));
  block.world_from_model_normal = glm::mat4(cofactor * block.handedness);
  return block;
}

}  // namespace furnace::gpu
