#include "renderer/compose_materials.hpp"

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/mesh_needs.hpp"

namespace furnace {
namespace {

template <class T, class U>
void replace(T& value, const std::optional<U>& with) {
  if (with) value = *with;
}

// A name as a reference token of a JSON pointer (RFC 6901).
std::string token_of(const std::string& name) {
  std::string token;
  for (const char c : name) token += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return token;
}

// glTF's archived KHR_materials_pbrSpecularGlossiness: its diffuse colour and glossiness go on, its texture of F0 and
// glossiness means nothing to the other workflow.
void make_metallic_roughness(Material& material) {
  if (!material.specular_glossiness) return;
  material.specular_glossiness = false;
  material.texture(TextureUse::kMetallicRoughness).reset();
}

bool says_metallic_roughness(const MaterialOverride& over) {
  const auto& texture = over.textures[std::size_t(TextureUse::kMetallicRoughness)];
  return over.metallic || over.perceptual_roughness || std::holds_alternative<TextureFile>(texture);
}

void replace_factors(Material& material, const MaterialOverride& over) {
  replace(material.model, over.model);
  replace(material.base_color, over.base_color);
  replace(material.metallic, over.metallic);
  replace(material.perceptual_roughness, over.perceptual_roughness);
  replace(material.emissive, over.emissive);
  replace(material.emissive_strength, over.emissive_strength);
  replace(material.normal_scale, over.normal_scale);
  replace(material.occlusion_strength, over.occlusion_strength);
  replace(material.alpha_mode, over.alpha_mode);
  replace(material.alpha_cutoff, over.alpha_cutoff);
  replace(material.double_sided, over.double_sided);
  replace(material.unlit, over.unlit);
}

void replace_layers(Material& material, const MaterialOverride& over) {
  replace(material.ior, over.ior);
  replace(material.specular, over.specular);
  replace(material.specular_color, over.specular_color);
  replace(material.clearcoat, over.clearcoat);
  replace(material.clearcoat_perceptual_roughness, over.clearcoat_perceptual_roughness);
  replace(material.clearcoat_normal_scale, over.clearcoat_normal_scale);
  replace(material.sheen_color, over.sheen_color);
  replace(material.sheen_perceptual_roughness, over.sheen_perceptual_roughness);
  replace(material.anisotropy, over.anisotropy);
  replace(material.anisotropy_rotation_rad, over.anisotropy_rotation_rad);
  replace(material.iridescence, over.iridescence);
  replace(material.iridescence_ior, over.iridescence_ior);
  replace(material.iridescence_thickness_min_nm, over.iridescence_thickness_min_nm);
  replace(material.iridescence_thickness_max_nm, over.iridescence_thickness_max_nm);
  replace(material.transmission, over.transmission);
  replace(material.thickness_m, over.thickness_m);
  replace(material.attenuation_distance_m, over.attenuation_distance_m);
  replace(material.attenuation_color, over.attenuation_color);
  material.attenuation_color = glm::max(material.attenuation_color, kLeastAttenuation);
  replace(material.dispersion, over.dispersion);
  replace(material.diffuse_transmission, over.diffuse_transmission);
  replace(material.diffuse_transmission_color, over.diffuse_transmission_color);
}

void note(ComposedScene& out, const Instance& instance, std::string code, const std::string& what) {
  const std::string& name = out.scene.materials[std::size_t(instance.material)].name;
  const std::string& mesh = out.scene.meshes[std::size_t(instance.mesh)]->name;
  out.scene.notes.push_back({std::move(code), "/scene/materials/" + token_of(name),
                             fmt::format("the mesh \"{}\" that wears it {}", mesh, what)});
}

}  // namespace

void MaterialComposer::apply(const std::string& name, Material& material) {
  const auto entry = spec_.materials.find(name);
  if (entry == spec_.materials.end()) return;
  used_.insert(name);
  const MaterialOverride& over = entry->second;
  const std::string pointer = "/scene/materials/" + token_of(name);
  if (over.preset) {
    auto preset = material_preset(*over.preset);
    if (!preset)
      fail(ErrorCode::kUnprocessable, fmt::format("there is no material preset \"{}\"", *over.preset),
           pointer);
    preset->name = material.name;
    preset->model = material.model;
    material = *std::move(preset);
  }
  if (says_metallic_roughness(over)) make_metallic_roughness(material);
  replace_factors(material, over);
  replace_layers(material, over);
  for (std::size_t use = 0; use < kTextureUses; ++use) {
    if (std::holds_alternative<NoTexture>(over.textures[use])) material.textures[use].reset();
    if (const auto* file = std::get_if<TextureFile>(&over.textures[use])) {
      const int image =
          add_image(file->encoded, fmt::format("{}/textures/{}", pointer, texture_use_name(TextureUse(use))));
      material.textures[use] = TextureSlot{image, file->uv_set, file->sampler, file->transform};
    }
  }
}

void MaterialComposer::note_unused() {
  for (const auto& [name, over] : spec_.materials) {
    if (used_.contains(name)) continue;
    scene_.notes.push_back({"material-unused", "/scene/materials/" + token_of(name),
                            fmt::format("nothing in the scene has a material named \"{}\"", name)});
  }
}

int MaterialComposer::add_image(const Blob& encoded, const std::string& pointer) {
  const auto [known, fresh] = images_.try_emplace(encoded.hash(), int(scene_.images.size()));
  if (fresh) scene_.images.push_back({encoded, pointer});
  return known->second;
}

void complete_meshes(ComposedScene& out) {
  for (const Instance& instance : out.scene.instances) {
    const Material& material = out.scene.materials[std::size_t(instance.material)];
    SharedMesh& shared = out.scene.meshes[std::size_t(instance.mesh)];
    if (is_complete(*shared, material)) continue;
    Mesh mesh = *shared;
    HashBuilder key;
    key.add("completed-mesh").add(mesh.key);
    const std::vector<int> filled = fill_uv_sets(mesh, material);
    for (const int uv_set : filled) {
      key.add(std::int64_t(uv_set));
      note(out, instance, "uv-set-missing",
           fmt::format("has no TEXCOORD_{}, which is needed; (0, 0) was used", uv_set));
    }
    const bool tangents = make_tangents(mesh, material);
    if (tangents) {
      key.add("tangents").add(std::int64_t(*tangent_uv_set(material)));
      note(out, instance, "tangents-generated",
           "has no TANGENT, which is needed; MikkTSpace tangents were made");
    }
    mesh.key = key.finish();
    shared = std::make_shared<const Mesh>(std::move(mesh));
  }
}

}  // namespace furnace
