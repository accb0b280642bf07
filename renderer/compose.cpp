#include "renderer/compose.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/base/error.hpp"
#include "renderer/compose_materials.hpp"
#include "renderer/scene/procedural.hpp"

namespace furnace {
namespace {

// The material a node names: a key of the request's materials, else a preset.
Material node_material(const SceneSpec& spec, std::size_t node) {
  const std::optional<std::string>& name = spec.nodes[node].material;
  if (!name) return default_material();
  if (spec.materials.contains(*name)) {
    // A request's own material starts from a plain white dielectric unless it names a preset.
    Material material;
    material.name = *name;
    material.metallic = 0;
    material.perceptual_roughness = 0.5f;
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

// The material of one part of a built-in mesh.
Material part_material(const SceneSpec& spec, std::size_t node, std::size_t part,
                       const std::string& part_name, MaterialComposer& composer) {
  if (part > 0) {
    if (auto fixed = builtin_part_material(part_name)) {
      fixed->model = spec.shading_model;
      return *fixed;
    }
  }
  Material material = node_material(spec, node);
  material.model = spec.shading_model;
  if (const auto& name = spec.nodes[node].material) composer.apply(*name, material);
  return material;
}

void add_node(const SceneSpec& spec, std::size_t index, MaterialComposer& composer, ComposedScene& out) {
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
    instance.place = -1 - std::int64_t(out.scene.instances.size());
    instance.node_name = node.name.value_or(fmt::format("/scene/nodes/{}", index));
    out.scene.materials.push_back(part_material(spec, index, part, mesh.name, composer));
    out.scene.instances.push_back(instance);
    mesh.key = HashBuilder().add("builtin-mesh").add(node.mesh).add(std::int64_t(part)).finish();
    out.scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  }
}

void check_variant(const std::string& name, const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  fail(ErrorCode::kUnprocessable,
       known.empty()
           ? "the model has no variants (KHR_materials_variants); leave it out"
           : fmt::format("the model has no variant \"{}\"; it has \"{}\"", name, fmt::join(known, "\", \"")),
       "/scene/variant");
}

void check_animations(const SceneSpec& spec, const std::vector<SceneAnimation>& known) {
  for (std::size_t i = 0; i < spec.animations.size(); ++i) {
    const auto& which = spec.animations[i].which;
    const int* index = std::get_if<int>(&which);
    const auto is_meant = [&](const SceneAnimation& animation) {
      return !index && animation.name == std::get<std::string>(which);
    };
    if (index ? *index < int(known.size()) : std::any_of(known.begin(), known.end(), is_meant)) continue;
    std::vector<std::string> names;
    for (const SceneAnimation& animation : known) names.push_back(fmt::format("\"{}\"", animation.name));
    constexpr std::size_t kMostNamed = 20;
    if (names.size() > kMostNamed) names.resize(kMostNamed);
    fail(ErrorCode::kUnprocessable,
         known.empty() ? "the model has no animations; leave it out"
                       : fmt::format("the model has no animation {}; it has {}: {}",
                                     index ? std::to_string(*index)
                                           : fmt::format("\"{}\"", std::get<std::string>(which)),
                                     known.size(), fmt::join(names, ", ")),
         spec.animations.size() == 1 ? "/scene/animation" : fmt::format("/scene/animations/{}", i));
  }
}

}  // namespace

ComposedScene compose_scene(const SceneSpec& spec, const Scene* model) {
  ComposedScene out;
  MaterialComposer composer(spec, out.scene);
  if (model != nullptr) {
    if (spec.variant) check_variant(*spec.variant, model->variants);
    check_animations(spec, model->animations);
    out.scene = *model;
    if (!spec.model_lights) out.scene.lights.clear();
    for (Material& material : out.scene.materials) {
      material.model = spec.shading_model;
      composer.apply(material.name, material);
    }
  }
  out.scene.lights.insert(out.scene.lights.end(), spec.lights.begin(), spec.lights.end());
  for (std::size_t i = 0; i < spec.nodes.size(); ++i) add_node(spec, i, composer, out);
  composer.note_unused();
  complete_meshes(out);
  out.bounds = world_bounds(out.scene);
  if (out.scene.instances.empty()) {
    out.scene.notes.push_back({"scene-empty", "/scene", "the scene draws nothing"});
  }
  return out;
}

}  // namespace furnace
