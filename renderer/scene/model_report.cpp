#include "renderer/scene/model_report.hpp"

#include <algorithm>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_usage.hpp"
#include "renderer/scene/model_report_parts.hpp"

namespace furnace {

namespace {

bool contains(const std::vector<std::string>& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

void check_variant(const Scene& scene, const std::optional<std::string>& variant) {
  if (!variant || contains(scene.variants, *variant)) return;
  fail(ErrorCode::kUnprocessable, "the model has no variant \"" + shortened(*variant) + "\"",
       "/extensions/KHR_materials_variants/variants");
}

// Nodes at and below each node.
std::vector<std::int64_t> subtree_sizes(const GltfDocument& document) {
  std::vector<int> order;  // parents before children
  for (std::size_t i = 0; i < document.nodes.size(); ++i)
    if (document.nodes[i].parent < 0) order.push_back(static_cast<int>(i));
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::vector<int>& children = document.nodes[static_cast<std::size_t>(order[i])].children;
    order.insert(order.end(), children.begin(), children.end());
  }
  std::vector<std::int64_t> sizes(document.nodes.size(), 1);
  for (auto node = order.rbegin(); node != order.rend(); ++node) {
    const int parent = document.nodes[static_cast<std::size_t>(*node)].parent;
    if (parent >= 0) sizes[static_cast<std::size_t>(parent)] += sizes[static_cast<std::size_t>(*node)];
  }
  return sizes;
}

std::int64_t nodes_of(const GltfScene& scene, const std::vector<std::int64_t>& subtrees) {
  std::int64_t nodes = 0;
  for (const int root : scene.nodes) nodes += subtrees[static_cast<std::size_t>(root)];
  return nodes;
}

void report_scenes(const ReportSource& source, const ImportOptions& options, ReportBudget& budget,
                   ModelReport& report) {
  const GltfDocument& document = source.document;
  const std::vector<std::int64_t> subtrees = subtree_sizes(document);
  report.default_scene = document.default_scene;
  report.nodes = std::int64_t(document.nodes.size());
  report.scenes = budget.list<ModelReport::SceneInfo>(document.scenes.size(), [&](std::size_t i) {
    return ModelReport::SceneInfo{budget.text(source.about.scene_names[i]),
                                  nodes_of(document.scenes[i], subtrees)};
  });
  report.drawn.nodes = report.nodes;
  if (document.scenes.empty()) return;
  report.drawn.scene = options.scene >= 0 ? options.scene : document.default_scene.value_or(0);
  report.drawn.nodes = nodes_of(document.scenes[static_cast<std::size_t>(*report.drawn.scene)], subtrees);
}

void report_named_things(const ReportSource& source, ReportBudget& budget, ModelReport& report) {
  const GltfDocument& document = source.document;
  report.skins = budget.list<ModelReport::SkinInfo>(document.skins.size(), [&](std::size_t i) {
    return ModelReport::SkinInfo{budget.text(source.about.skin_names[i]),
                                 std::int64_t(document.skins[i].joints.size())};
  });
  report.cameras = budget.list<CameraNode>(document.cameras.size(), [&](std::size_t i) {
    CameraNode camera = document.cameras[i];
    camera.name = budget.text(camera.name);
    return camera;
  });
  report.lights = budget.list<ModelReport::LightInfo>(document.lights.size(), [&](std::size_t i) {
    const std::optional<Light>& light = document.lights[i];
    if (!light) return ModelReport::LightInfo{};
    return ModelReport::LightInfo{budget.text(light->name), light->kind};
  });
  report.variants = budget.texts(document.variants);
}

void report_extensions(const ReportSource& source, ReportBudget& budget, ModelReport& report) {
  const std::vector<std::string_view> supported = supported_gltf_extensions();
  std::vector<std::string> unsupported;
  for (const std::string& name : source.document.extensions_used)
    if (std::find(supported.begin(), supported.end(), name) == supported.end()) unsupported.push_back(name);
  const std::vector<std::string>& undeclared = source.about.extensions_undeclared;
  unsupported.insert(unsupported.end(), undeclared.begin(), undeclared.end());
  report.extensions.used = budget.texts(source.document.extensions_used);
  report.extensions.required = budget.texts(source.about.extensions_required);
  report.extensions.unsupported = budget.texts(unsupported);
}

void report_bytes(const ReportSource& source, ModelReport& report) {
  const Blob& document = source.bundle.document;
  report.bytes.document = std::int64_t(document.size());
  report.bytes.json = std::int64_t(open_gltf_container(document).json.size);
  for (const GltfBuffer& buffer : source.document.buffers)
    report.bytes.buffers += std::int64_t(buffer.byte_length);
}

void report_unused(const ReportSource& source, ReportBudget& budget, ModelReport& report) {
  const GltfUsage usage = gltf_usage(source.document, source.about);
  const auto unmarked = [&](const std::vector<bool>& marks) {
    std::vector<int> indices;
    for (std::size_t i = 0; i < marks.size(); ++i)
      if (!marks[i]) indices.push_back(static_cast<int>(i));
    return budget.list<int>(indices.size(), [&](std::size_t i) { return indices[i]; });
  };
  ModelReport::Unused& unused = report.unused;
  unused.nodes = unmarked(usage.nodes);
  unused.meshes = unmarked(usage.meshes);
  unused.materials = unmarked(usage.materials);
  unused.textures = unmarked(usage.textures);
  unused.images = unmarked(usage.images);
  unused.skins = unmarked(usage.skins);
  unused.cameras = unmarked(usage.cameras);
  unused.accessors = unmarked(usage.accessors);
  unused.buffer_views = unmarked(usage.buffer_views);
}

}  // namespace

void report_drawn(const Scene& scene, ModelReport& report) {
  ModelReport::Drawn& drawn = report.drawn;
  drawn.instances = std::int64_t(scene.instances.size());
  drawn.meshes = std::int64_t(scene.meshes.size());
  drawn.materials = std::int64_t(scene.materials.size());
  drawn.images = std::int64_t(scene.images.size());
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[static_cast<std::size_t>(instance.mesh)];
    const auto indices = std::int64_t(mesh.indices.size());
    drawn.vertices += std::int64_t(mesh.positions.size());
    if (mesh.topology == Topology::kPoints) drawn.points += indices;
    if (mesh.topology == Topology::kLines) drawn.lines += indices / 2;
    if (mesh.topology == Topology::kTriangles) drawn.triangles += indices / 3;
  }
  drawn.bounds = world_bounds(scene);
  for (const SharedMesh& mesh : scene.meshes) report.bytes.meshes += std::int64_t(mesh->byte_size());
}

ModelReport inspect_gltf(Decoder& decoder, const ModelBundle& bundle, const ImportOptions& options,
                         const ImportLimits& limits, const Deadline& deadline,
                         const ReportLimits& report_limits) {
  FURNACE_CHECK(bundle.format == ModelFormat::kGltf, "a model that is no glTF");
  const Scene scene = import_gltf(decoder, bundle, options, limits, deadline);
  check_variant(scene, options.variant);
  const GltfDocument document = read_gltf_document(bundle.document, limits);
  const GltfData data(document, bundle, limits, decoder, deadline);
  const GltfAbout about = read_gltf_about(bundle.document, document);
  const ReportSource source{bundle, document, data, about, limits, deadline};
  ReportBudget budget(report_limits);
  GltfNotes notes;
  for (const Note& note : scene.notes) notes.add(note.code, note.pointer, note.message);

  ModelReport report;
  report.hash = bundle.hash;
  report.asset = {bundle.document.text().starts_with("glTF") ? "glb" : "gltf",
                  budget.text(about.asset.version), budget.text(about.asset.generator),
                  budget.text(about.asset.copyright)};
  report.drawn.variant = options.variant;
  report_scenes(source, options, budget, report);
  report_extensions(source, budget, report);
  report_named_things(source, budget, report);
  report_drawn(scene, report);
  report_bytes(source, report);
  report_materials(source, budget, report);
  report_images(source, budget, notes, report);
  report_meshes(source, budget, report);
  report_animations(source, scene, budget, report);
  report_unused(source, budget, report);
  report.notes = notes.take();
  return report;
}

ModelReport inspect_model(Decoder& decoder, const ModelBundle& bundle, const ImportOptions& options,
                          const ImportLimits& limits, const Deadline& deadline,
                          const ReportLimits& report_limits) {
  if (bundle.format == ModelFormat::kGltf)
    return inspect_gltf(decoder, bundle, options, limits, deadline, report_limits);
  if (options.scene >= 0 || options.variant)
    fail(ErrorCode::kUnprocessable, "is no glTF: it has no scenes and no variants to choose from");
  return inspect_plain(decoder, bundle, limits, deadline, report_limits);
}

}  // namespace furnace
