#include "renderer/scene/model_import.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/image/color.hpp"
#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/mesh_needs.hpp"
#include "renderer/scene/model_material.hpp"
#include "renderer/scene/precision.hpp"
#include "renderer/scene/tangents.hpp"
#include "renderer/scene/text_lines.hpp"

namespace furnace {
namespace {

constexpr const char* kModelPlace = "/scene/model";

PlainModelLimits limits_of(const ImportLimits& limits) {
  PlainModelLimits out;
  out.max_vertices = limits.max_vertices;
  out.max_elements = limits.max_triangles;
  out.max_bytes = limits.max_mesh_bytes;
  return out;
}

// All MTL files that are there, in the document's order, as one; the others are told, and materials that none of them has.
MtlText materials_of(const ModelBundle& bundle, GltfNotes& notes) {
  if (bundle.format != ModelFormat::kObj) return {};
  std::string text;
  bool complete = true;
  const std::string_view document = without_mark(bundle.document.text());
  for (const std::string& name : material_libraries(document)) {
    const auto file = bundle.siblings.find(name);
    if (file == bundle.siblings.end()) {
      complete = false;
      notes.add("materials-missing", "/mtllib/" + name,
                fmt::format("there is no file \"{}\" beside the model; its materials are grey", name));
    } else {
      text += without_mark(file->second.text());
      text += '\n';
    }
  }
  MtlText mtl = read_mtl(text, notes);
  for (const std::string& name : complete ? named_materials(document) : std::vector<std::string>())
    if (!mtl.materials.contains(name))
      notes.add("material-missing", "/usemtl/" + readable_text(name), "is in no MTL file; it is grey");
  return mtl;
}

// 3D Gaussian splatting (Kerbl et al. 2023) keeps its ellipsoids in a PLY.
bool has_splats(std::string_view ply) {
  const std::string_view header = ply.substr(0, ply.find("end_header"));
  return header.find(" f_dc_0") != header.npos && header.find(" scale_0") != header.npos;
}

// What the readers have no way to tell.
void tell_omissions(const ModelBundle& bundle, GltfNotes& notes) {
  const std::string_view document = bundle.document.text();
  if (bundle.format == ModelFormat::kObj && has_free_forms(document))
    notes.add("geometry-ignored", "", "has free-form curves or surfaces, which were left out");
  if (bundle.format == ModelFormat::kPly && has_splats(document))
    notes.add("geometry-ignored", "", "has splats, which were drawn as points");
  constexpr std::size_t kEndSeen = 4096;
  const bool is_text =
      bundle.format == ModelFormat::kStl && !binary_stl_facets(bundle.document) && is_text_stl(document);
  if (is_text &&
      lower(document.substr(document.size() - std::min(kEndSeen, document.size()))).find("endsolid") ==
          std::string::npos)
    notes.add("file-incomplete", "", "has no \"endsolid\" at its end; facets may be missing");
}

template <class Value>
std::vector<Value> slice(const std::vector<Value>& all, std::uint32_t has, std::size_t first,
                         std::size_t count) {
  if (has == 0) return {};
  const auto begin = all.begin() + std::ptrdiff_t(first);
  return {begin, begin + std::ptrdiff_t(count)};
}

void make_colors_linear(std::vector<glm::vec4>& colors) {
  for (glm::vec4& color : colors)
    for (int i = 0; i < 3; ++i) color[i] = float(linear_from_srgb(color[i]));
}

Mesh mesh_of(const PlainModel& model, const PlainPart& part, std::size_t vertex, std::size_t index) {
  Mesh mesh;
  mesh.name = readable_text(model.text_of(part.name));
  mesh.topology = Topology(part.topology);
  mesh.positions = slice(model.positions, 1, vertex, part.vertices);
  mesh.normals = slice(model.normals, part.has_normals, vertex, part.vertices);
  mesh.uvs[0] = slice(model.uvs, part.has_uvs, vertex, part.vertices);
  mesh.colors = slice(model.colors, part.has_colors, vertex, part.vertices);
  mesh.indices = slice(model.indices, 1, index, part.indices);
  make_colors_linear(mesh.colors);
  for (const glm::vec3& position : mesh.positions) mesh.bounds.add(position);
  return mesh;
}

glm::mat4 world_from_file(UpAxis up) {
  glm::mat4 turn(1);
  if (up == UpAxis::kY) return turn;
  turn[1] = {0, 0, -1, 0};  // the file's +Y lies behind
  turn[2] = {0, 1, 0, 0};
  return turn;
}

void tell_normals(const PlainModel& model, GltfNotes& notes) {
  const auto made =
      std::ranges::count_if(model.parts, [](const PlainPart& part) { return part.made_normals != 0; });
  if (made == 0) return;
  notes.add(
      "normals-generated", "",
      fmt::format("{} of {} parts have no normals; smooth ones were made, with edges from 45 degrees on",
                  made, model.parts.size()));
}

UpAxis up_axis_of(ModelFormat format, std::optional<UpAxis> up, GltfNotes& notes) {
  if (up || format != ModelFormat::kStl) return up.value_or(UpAxis::kY);
  notes.add("up-axis-assumed", "", "STL does not say which axis is up; +Z was taken, scene.upAxis says it");
  return UpAxis::kZ;
}

PlainModel decoded(const ModelBundle& bundle, const MtlText& mtl, const ImportLimits& limits,
                   Decoder& decoder, const Deadline& deadline) {
  try {
    return decoder.model(bundle.document, mtl.text, bundle.format, limits_of(limits), deadline);
  } catch (Error& error) {
    if (error.pointer.empty()) error.pointer = kModelPlace;
    throw;
  }
}

}  // namespace

Scene import_model(const ModelBundle& bundle, std::optional<UpAxis> up, const ImportLimits& limits,
                   Decoder& decoder, const Deadline& deadline) {
  GltfNotes notes;
  Scene scene;
  const UpAxis axis = up_axis_of(bundle.format, up, notes);
  scene.hash = HashBuilder().add("model").add(bundle.hash).add(std::int64_t(axis)).finish();
  const MtlText mtl = materials_of(bundle, notes);
  const PlainModel model = decoded(bundle, mtl, limits, decoder, deadline);
  check_deadline(deadline, "import");
  tell_omissions(bundle, notes);
  tell_normals(model, notes);

  MaterialMaker materials(model, mtl, bundle, decoder, deadline, scene, notes);
  std::size_t vertex = 0, index = 0;
  for (std::size_t i = 0; i < model.parts.size(); ++i) {
    const PlainPart& part = model.parts[i];
    Mesh mesh = mesh_of(model, part, vertex, index);
    vertex += part.vertices;
    index += part.indices;
    Instance instance;
    instance.material = materials.material(part.material, part.has_colors != 0);
    const Material& material = scene.materials[std::size_t(instance.material)];
    if (mesh.topology == Topology::kTriangles && mesh.normals.empty()) generate_flat_normals(mesh);
    if (!fill_uv_sets(mesh, material).empty())
      notes.add("uv-set-missing", fmt::format("/parts/{}", i), "has no texture coordinates; (0, 0) was used");
    make_tangents(mesh, material);
    instance.mesh = int(scene.meshes.size());
    instance.place = std::int64_t(i);
    instance.world_from_model = world_from_file(axis);
    instance.node_name = mesh.name.empty() ? fmt::format("/parts/{}", i) : mesh.name;
    mesh.key =
        HashBuilder().add("model-mesh").add(scene.hash).add(std::int64_t(scene.meshes.size())).finish();
    scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
    scene.instances.push_back(std::move(instance));
  }
  if (auto note = precision_note(scene)) notes.add(note->code, note->pointer, note->message);
  scene.notes = notes.take();
  return scene;
}

std::vector<std::string> model_siblings(const Blob& document, ModelFormat format,
                                        const ImportLimits& limits) {
  switch (format) {
    case ModelFormat::kGltf:
      return gltf_external_uris(document, limits);
    case ModelFormat::kObj:
      return material_libraries(document.text());
    case ModelFormat::kPly:
      return ply_texture_names(document.text());
    case ModelFormat::kStl:
      break;
  }
  return {};
}

}  // namespace furnace
