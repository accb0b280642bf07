#include "renderer/compose.hpp"

#include <set>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/base/error.hpp"
#include "renderer/scene/procedural.hpp"

namespace furnace {
namespace {

template <class T, class U>
void replace(T& value, const std::optional<U>& with) {
  if (with) value = *with;
}

void apply(const MaterialOverride& over, const std::string& key, Material& material) {
  if (over.preset) {
    const auto preset = material_preset(*over.preset);
    if (!preset) {
      fail(ErrorCode::kUnprocessable, fmt::format("there is no material preset \"{}\"", *over.preset),
           fmt::format("/scene/materials/{}", key));
    }
    const std::string name = material.name;
    material = *preset;
    material.name = name;
  }
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

// The material a node names: a key of the request's materials, else a preset.
Material node_material(const SceneSpec& spec, std::size_t node, std::set<std::string>& used) {
  const std::optional<std::string>& name = spec.nodes[node].material;
  if (!name) return default_material();
  if (const auto entry = spec.materials.find(*name); entry != spec.materials.end()) {
    used.insert(*name);
    // A request's own material starts from a plain white dielectric unless it names a preset.
    Material material;
    material.name = *name;
    material.metallic = 0;
    material.perceptual_roughness = 0.5f;
    apply(entry->second, *name, material);
    return material;
  }
  if (auto preset = material_preset(*name)) return *preset;
  fail(ErrorCode::kUnprocessable,
       fmt::format("\"{}\" is neither a key of scene.materials nor a material preset", *name),
       fmt::format("/scene/nodes/{}/material", node));
}

glm::mat4 world_from_node(const NodeSpec& node) {
  return glm::scale(glm::translate(glm::mat4(1), node.translation) * glm::mat4_cast(node.rotation),
                    node.scale);
}

void add_node(const SceneSpec& spec, std::size_t index, std::set<std::string>& used, ComposedScene& out) {
  const NodeSpec& node = spec.nodes[index];
  auto meshes = builtin_mesh(node.mesh);
  if (!meshes) {
    fail(ErrorCode::kUnprocessable, fmt::format("there is no built-in mesh \"{}\"", node.mesh),
         fmt::format("/scene/nodes/{}/mesh", index));
  }
  for (std::size_t part = 0; part < meshes->size(); ++part) {
    Mesh& mesh = (*meshes)[part];
    Instance instance;
    instance.mesh = int(out.scene.meshes.size());
    instance.material = int(out.scene.materials.size());
    instance.world_from_model = world_from_node(node);
    const auto fixed = builtin_part_material(mesh.name);
    out.scene.materials.push_back(part > 0 && fixed ? *fixed : node_material(spec, index, used));
    out.scene.instances.push_back(instance);
    out.mesh_keys.push_back(
        HashBuilder().add("builtin-mesh").add(node.mesh).add(std::int64_t(part)).finish());
    out.scene.meshes.push_back(std::move(mesh));
  }
}

}  // namespace

ComposedScene compose_scene(const SceneSpec& spec, const Scene* model) {
  ComposedScene out;
  std::set<std::string> used;
  if (model != nullptr) {
    out.scene = *model;
    for (std::size_t i = 0; i < model->meshes.size(); ++i) {
      out.mesh_keys.push_back(HashBuilder().add("gltf-mesh").add(model->hash).add(std::int64_t(i)).finish());
    }
    if (!spec.model_lights) out.scene.lights.clear();
    for (Material& material : out.scene.materials) {
      const auto entry = spec.materials.find(material.name);
      if (entry == spec.materials.end()) continue;
      used.insert(material.name);
      apply(entry->second, material.name, material);
    }
  }
  out.scene.lights.insert(out.scene.lights.end(), spec.lights.begin(), spec.lights.end());
  for (std::size_t i = 0; i < spec.nodes.size(); ++i) add_node(spec, i, used, out);
  for (const auto& [name, over] : spec.materials) {
    if (used.contains(name)) continue;
    out.scene.notes.push_back({"material-unused", "/scene/materials/" + name,
                               fmt::format("nothing in the scene has a material named \"{}\"", name)});
  }
  out.bounds = world_bounds(out.scene);
  if (out.scene.instances.empty()) {
    out.scene.notes.push_back({"scene-empty", "/scene", "the scene draws nothing"});
  }
  return out;
}

}  // namespace furnace
