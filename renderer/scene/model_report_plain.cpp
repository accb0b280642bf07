// Reports of models that are no glTF: what they were imported as.
#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "renderer/scene/model_import.hpp"
#include "renderer/scene/model_report_parts.hpp"

namespace furnace {

namespace {

std::string_view container_of(ModelFormat format) {
  switch (format) {
    case ModelFormat::kObj:
      return "obj";
    case ModelFormat::kStl:
      return "stl";
    default:
      return "ply";
  }
}

std::vector<ModelReport::Attribute> attributes_of(const Mesh& mesh) {
  std::vector<ModelReport::Attribute> attributes = {{"POSITION", "VEC3", "float"}};
  if (!mesh.normals.empty()) attributes.push_back({"NORMAL", "VEC3", "float"});
  if (!mesh.tangents.empty()) attributes.push_back({"TANGENT", "VEC4", "float"});
  for (std::size_t set = 0; set < mesh.uvs.size(); ++set)
    if (!mesh.uvs[set].empty()) attributes.push_back({"TEXCOORD_" + std::to_string(set), "VEC2", "float"});
  if (!mesh.colors.empty()) attributes.push_back({"COLOR_0", "VEC4", "float"});
  return attributes;
}

// glTF's number of the mode.
int mode_of(Topology topology) {
  constexpr int kPoints = 0, kLines = 1, kTriangles = 4;
  if (topology == Topology::kPoints) return kPoints;
  return topology == Topology::kLines ? kLines : kTriangles;
}

ModelReport::MeshInfo mesh_info(const Mesh& mesh, const Instance& instance, ReportBudget& budget) {
  ModelReport::Primitive part;
  part.mode = mode_of(mesh.topology);
  part.topology = mesh.topology;
  part.vertices = std::int64_t(mesh.positions.size());
  const std::size_t corners = part.mode == 0 ? 1 : part.mode == 1 ? 2 : 3;
  part.elements = std::int64_t(mesh.indices.size() / corners);
  part.material = instance.material;
  part.bounds = mesh.bounds;
  const std::vector<ModelReport::Attribute> attributes = attributes_of(mesh);
  part.attributes =
      budget.list<ModelReport::Attribute>(attributes.size(), [&](std::size_t i) { return attributes[i]; });
  ModelReport::MeshInfo info;
  info.name = budget.text(instance.node_name);
  info.nodes = 1;
  info.primitives = budget.list<ModelReport::Primitive>(1, [&](std::size_t) { return part; });
  return info;
}

ModelReport::MaterialInfo material_info(const Material& material, ReportBudget& budget) {
  ModelReport::MaterialInfo info;
  info.name = budget.text(material.name);
  info.alpha_mode = material.alpha_mode;
  info.double_sided = material.double_sided;
  std::vector<ModelReport::TextureUseInfo> uses;
  for (std::size_t use = 0; use < kTextureUses; ++use) {
    const auto& slot = material.textures[use];
    if (slot)
      uses.push_back({texture_use_name(TextureUse(use)), slot->image, slot->image, slot->uv_set,
                      slot->transform != UvTransform()});
  }
  info.textures =
      budget.list<ModelReport::TextureUseInfo>(uses.size(), [&](std::size_t i) { return uses[i]; });
  return info;
}

std::vector<ImageWanted> wanted_images(const Scene& scene) {
  std::vector<ImageWanted> wanted(scene.images.size());
  for (const Material& material : scene.materials) {
    for (std::size_t use = 0; use < kTextureUses; ++use) {
      if (!material.textures[use]) continue;
      ImageWanted& entry = wanted[std::size_t(material.textures[use]->image)];
      (is_color_texture(material, TextureUse(use)) ? entry.as_color : entry.as_numbers) = true;
    }
  }
  return wanted;
}

// By image, as the first material that shows it has it.
std::vector<SamplerDesc> samplers_of(const Scene& scene) {
  std::vector<std::optional<SamplerDesc>> first(scene.images.size());
  for (const Material& material : scene.materials)
    for (const auto& slot : material.textures)
      if (slot && !first[std::size_t(slot->image)]) first[std::size_t(slot->image)] = slot->sampler;
  std::vector<SamplerDesc> samplers;
  for (const auto& sampler : first) samplers.push_back(sampler.value_or(SamplerDesc()));
  return samplers;
}

// Of the files that the model and those beside it name.
std::vector<std::string> missing_files(const ModelBundle& bundle, const ImportLimits& limits) {
  std::vector<std::string> names = model_siblings(bundle.document, bundle.format, limits);
  std::set<std::string> seen(names.begin(), names.end());
  for (std::size_t i = 0, libraries = bundle.format == ModelFormat::kObj ? names.size() : 0; i < libraries;
       ++i) {
    const auto library = bundle.siblings.find(names[i]);
    if (library == bundle.siblings.end()) continue;
    for (std::string& name : texture_names(library->second.text()))
      if (seen.insert(name).second) names.push_back(std::move(name));
  }
  std::erase_if(names, [&](const std::string& name) { return bundle.siblings.contains(name); });
  return names;
}

void report_images(const Scene& scene, ReportBudget& budget, GltfNotes& notes, ModelReport& report) {
  const std::vector<ImageWanted> wanted = wanted_images(scene);
  const auto counted = [&](std::size_t i) {
    ModelReport::ImageInfo info;
    describe_image(scene.images[i].encoded, wanted[i], scene.images[i].pointer, notes, info);
    count_image(info, report);
    return info;
  };
  report.images = budget.list<ModelReport::ImageInfo>(scene.images.size(), counted);
  for (std::size_t i = report.images.items.size(); i < scene.images.size(); ++i) counted(i);
  const std::vector<SamplerDesc> samplers = samplers_of(scene);
  report.textures = budget.list<ModelReport::TextureInfo>(scene.images.size(), [&](std::size_t i) {
    return ModelReport::TextureInfo{{}, int(i), samplers[i]};
  });
}

}  // namespace

ModelReport inspect_plain(Decoder& decoder, const ModelBundle& bundle, const ImportLimits& limits,
                          const Deadline& deadline, const ReportLimits& report_limits) {
  const Scene scene = import_model(bundle, {}, limits, decoder, deadline);
  ReportBudget budget(report_limits);
  GltfNotes notes;
  for (const Note& note : scene.notes) notes.add(note.code, note.pointer, note.message);

  ModelReport report;
  report.hash = bundle.hash;
  report.asset.container = container_of(bundle.format);
  report.nodes = report.drawn.nodes = std::int64_t(scene.instances.size());
  report_drawn(scene, report);
  report.vertices = report.drawn.vertices;
  report.bytes.document = std::int64_t(bundle.document.size());
  report.materials = budget.list<ModelReport::MaterialInfo>(
      scene.materials.size(), [&](std::size_t i) { return material_info(scene.materials[i], budget); });
  report_images(scene, budget, notes, report);
  report.meshes = budget.list<ModelReport::MeshInfo>(scene.instances.size(), [&](std::size_t i) {
    const Instance& instance = scene.instances[i];
    return mesh_info(*scene.meshes[std::size_t(instance.mesh)], instance, budget);
  });
  report.missing_files = budget.texts(missing_files(bundle, limits));
  report.notes = notes.take();
  return report;
}

}  // namespace furnace
