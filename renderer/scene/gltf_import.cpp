#include "renderer/scene/gltf_import.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_animation.hpp"
#include "renderer/scene/gltf_deform.hpp"
#include "renderer/scene/gltf_instances.hpp"
#include "renderer/scene/gltf_material.hpp"
#include "renderer/scene/gltf_model.hpp"
#include "renderer/scene/gltf_pose.hpp"
#include "renderer/scene/gltf_surface.hpp"
#include "renderer/scene/mesh_needs.hpp"
#include "renderer/scene/precision.hpp"

namespace furnace {

namespace {

// Turns one scene of a document into a Scene.
// Threads: one. Owns: the scene in the making.
class Importer {
 public:
  explicit Importer(GltfModel::State& model)
      : model_(model),
        limits_(model.limits),
        deadline_(model.deadline),
        document_(model.document),
        data_(model.data),
        materials_(document_, data_, model.bundle, scene_, notes_) {}

  Scene import(const ImportOptions& options);

 private:
  std::vector<int> root_nodes(int wanted_scene) const;
  std::vector<int> nodes_in_order(const std::vector<int>& roots) const;
  void note_ignored_extensions();
  void play(const std::vector<AnimationClip>& clips);
  void hide(const std::vector<int>& parents_first);
  void choose_variant(const std::optional<std::string>& name);
  std::optional<int> material_of(const GltfPrimitive& primitive) const;
  void add_cameras(const std::vector<int>& nodes);
  void add_lights(const std::vector<int>& nodes);
  void add_mesh(int node_index);
  void note_instances(int node_index);
  const std::vector<glm::dmat4>& world_from_bind(int skin);
  std::optional<Instance> shared_primitive(const GltfPrimitiveRef& ref);
  std::optional<Instance> import_primitive(const GltfPrimitiveRef& ref, const std::vector<double>& weights,
                                           const std::vector<glm::dmat4>* joints);
  Instance add_shared(const SharedMesh& mesh, int scene_material, const GltfPrimitiveRef& ref);
  int tangent_set_of(int scene_material) const;
  // Of all else that a mesh is made from: attributes and textures are the document's.
  ContentHash source_of(const GltfPrimitiveRef& ref, const std::vector<double>& weights,
                        const std::vector<glm::dmat4>* joints, std::optional<int> material) const;
  void check_size(const GltfPrimitiveRef& ref) const;
  void count_mesh(const Mesh& mesh, const GltfPrimitiveRef& ref);
  void add_instance(Instance instance, int node_index, const glm::dmat4& world_from_model);

  GltfModel::State& model_;
  const ImportLimits& limits_;
  const Deadline& deadline_;
  GltfNotes notes_;
  Scene scene_;
  GltfDocument document_;
  const GltfData& data_;
  GltfMaterials materials_;
  std::vector<bool> hidden_;  // by node
  std::vector<glm::dmat4> world_from_node_;
  std::map<int, std::vector<glm::dmat4>> skins_;                // joint matrices, by skin
  std::map<GltfPrimitiveRef, std::optional<Instance>> shared_;  // meshes as they are for every plain node
  std::optional<int> variant_;                                  // index into document_.variants
  std::int64_t vertices_ = 0, mesh_bytes_ = 0, elements_drawn_ = 0, instances_ = 0;
};

Scene Importer::import(const ImportOptions& options) {
  note_ignored_extensions();
  choose_variant(options.variant);
  play(options.animations);
  world_from_node_ = world_transforms(document_, notes_);
  const std::vector<int> nodes = nodes_in_order(root_nodes(options.scene));
  hide(nodes);
  for (const int node : nodes) {
    if (document_.nodes[static_cast<std::size_t>(node)].mesh && !hidden_[std::size_t(node)]) add_mesh(node);
  }
  add_cameras(nodes);
  add_lights(nodes);
  if (scene_.materials.empty()) scene_.materials.push_back(default_material());
  scene_.variants = document_.variants;
  HashBuilder hash;
  hash.add(model_.bundle.hash).add(std::int64_t{options.scene});
  if (variant_) hash.add("variant").add(std::int64_t{*variant_});
  for (const AnimationClip& clip : options.animations) {
    if (const int* index = std::get_if<int>(&clip.which)) {
      hash.add("animation").add(std::int64_t{*index});
    } else {
      hash.add("animation-name").add(std::get<std::string>(clip.which));
    }
    hash.add(clip.time.seconds).add(std::int64_t{clip.time.loop});
  }
  scene_.hash = hash.finish();
  if (auto note = precision_note(scene_)) notes_.add(note->code, note->pointer, note->message);
  scene_.notes = notes_.take();
  return std::move(scene_);
}

void Importer::note_ignored_extensions() {
  const std::vector<std::string_view> supported = supported_gltf_extensions();
  for (std::size_t i = 0; i < document_.extensions_used.size(); ++i) {
    const std::string& name = document_.extensions_used[i];
    if (std::find(supported.begin(), supported.end(), name) != supported.end()) continue;
    notes_.add("extension-ignored", "/extensionsUsed/" + std::to_string(i),
               shortened(name) + " is not supported and was ignored");
  }
  for (const auto& [name, pointer] : model_.undeclared)
    notes_.add("extension-ignored", pointer,
               shortened(name) + " is not supported, nor in extensionsUsed, and was ignored");
}

void Importer::play(const std::vector<AnimationClip>& clips) {
  KeyframeReader keyframes(data_, limits_, deadline_);
  scene_.animations = list_animations(document_, keyframes, notes_);
  if (clips.empty()) return;
  GltfJson posed = model_.json;
  for (const AnimationClip& clip : clips) {
    if (const auto animation = find_animation(document_, clip.which))
      pose_document(posed.root, document_, keyframes, *animation, clip.time, notes_);
  }
  document_ = read_checked_gltf(posed, limits_);
}

// KHR_node_visibility: a node hides all below it, whatever they say themselves.
void Importer::hide(const std::vector<int>& parents_first) {
  hidden_.assign(document_.nodes.size(), false);
  for (const int index : parents_first) {
    const GltfNode& node = document_.nodes[std::size_t(index)];
    hidden_[std::size_t(index)] = !node.visible || (node.parent >= 0 && hidden_[std::size_t(node.parent)]);
  }
}

void Importer::choose_variant(const std::optional<std::string>& name) {
  if (!name) return;
  const std::vector<std::string>& known = document_.variants;
  const auto found = std::find(known.begin(), known.end(), *name);
  if (found != known.end()) variant_ = static_cast<int>(found - known.begin());
}

// KHR_materials_variants: a primitive that the variant does not name keeps its own material.
std::optional<int> Importer::material_of(const GltfPrimitive& primitive) const {
  if (!variant_) return primitive.material;
  const auto mapped = primitive.variant_materials.find(*variant_);
  return mapped == primitive.variant_materials.end() ? primitive.material : mapped->second;
}

std::vector<int> Importer::root_nodes(int wanted_scene) const {
  const int count = static_cast<int>(document_.scenes.size());
  if (wanted_scene >= count) {
    fail(ErrorCode::kUnprocessable,
         "scene " + std::to_string(wanted_scene) + " does not exist, there are " + std::to_string(count),
         "/scenes");
  }
  if (wanted_scene < 0) wanted_scene = document_.default_scene.value_or(0);
  if (count > 0) return document_.scenes[static_cast<std::size_t>(wanted_scene)].nodes;
  std::vector<int> roots;
  for (std::size_t i = 0; i < document_.nodes.size(); ++i) {
    if (document_.nodes[i].parent < 0) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

// Parents before children, siblings in the file's order.
std::vector<int> Importer::nodes_in_order(const std::vector<int>& roots) const {
  std::vector<int> order;
  std::vector<int> open(roots.rbegin(), roots.rend());
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    order.push_back(node);
    const std::vector<int>& children = document_.nodes[static_cast<std::size_t>(node)].children;
    open.insert(open.end(), children.rbegin(), children.rend());
  }
  return order;
}

// In the order of the document's cameras, so that an index means what it says when each is used once.
void Importer::add_cameras(const std::vector<int>& nodes) {
  std::vector<std::pair<int, int>> placed;  // camera, node
  for (const int node : nodes) {
    if (const auto camera = document_.nodes[static_cast<std::size_t>(node)].camera)
      placed.emplace_back(*camera, node);
  }
  std::stable_sort(placed.begin(), placed.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [camera_index, node_index] : placed) {
    CameraNode camera = document_.cameras[static_cast<std::size_t>(camera_index)];
    if (camera.name.empty()) camera.name = document_.nodes[static_cast<std::size_t>(node_index)].name;
    camera.world_from_view = camera_transform(world_from_node_[static_cast<std::size_t>(node_index)]);
    scene_.cameras.push_back(std::move(camera));
  }
}

// KHR_lights_punctual: a light shines along -Z of its node, whose scale does not count.
void Importer::add_lights(const std::vector<int>& nodes) {
  for (const Note& note : document_.light_notes) notes_.add(note.code, note.pointer, note.message);
  for (const int node_index : nodes) {
    const GltfNode& node = document_.nodes[static_cast<std::size_t>(node_index)];
    if (!node.light || hidden_[std::size_t(node_index)]) continue;
    const std::optional<Light>& known = document_.lights[static_cast<std::size_t>(*node.light)];
    if (!known) {
      notes_.add("light-ignored",
                 "/extensions/KHR_lights_punctual/lights/" + std::to_string(*node.light) + "/type",
                 "is none of directional, point and spot; the light was left out");
      continue;
    }
    Light light = *known;
    if (light.name.empty()) light.name = node.name;
    const glm::dmat4 world_from_light(
        camera_transform(world_from_node_[static_cast<std::size_t>(node_index)]));
    light.position = glm::dvec3(world_from_light[3]);
    light.direction = -glm::dvec3(world_from_light[2]);
    scene_.lights.push_back(std::move(light));
  }
}

void Importer::add_mesh(int node_index) {
  const GltfNode& node = document_.nodes[static_cast<std::size_t>(node_index)];
  const GltfMesh& mesh = document_.meshes[static_cast<std::size_t>(*node.mesh)];
  const glm::dmat4& world_from_model = world_from_node_[static_cast<std::size_t>(node_index)];
  const std::vector<glm::dmat4>* joints = node.skin ? &world_from_bind(*node.skin) : nullptr;
  const std::vector<glm::dmat4> places =
      instance_transforms(document_, data_, node_index, instances_, limits_.max_instances);
  if (!node.instances.empty()) instances_ += std::int64_t(places.size());
  note_instances(node_index);
  if (mesh.primitives.empty())
    notes_.add("primitive-skipped", "/meshes/" + std::to_string(*node.mesh) + "/primitives",
               "has none; nothing is drawn");

  constexpr std::int64_t kPartsOfNode = std::int64_t{1} << 32;
  for (int i = 0; i < static_cast<int>(mesh.primitives.size()); ++i) {
    const GltfPrimitiveRef ref{*node.mesh, i};
    const bool skinned = node.skin && primitive_of(document_, ref).attributes.contains("JOINTS_0");
    if (node.skin && !skinned) {
      notes_.add("skin-ignored", "/nodes/" + std::to_string(node_index) + "/skin",
                 "its mesh has no JOINTS_0; the node's own transform was used");
    }
    const bool own = skinned || !node.weights.empty();
    const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
    std::optional<Instance> instance =
        own ? import_primitive(ref, weights, skinned ? joints : nullptr) : shared_primitive(ref);
    if (!instance) continue;
    instance->place = node_index * kPartsOfNode + i * static_cast<std::int64_t>(places.size());
    // glTF 2.0, section 3.7.3.3: only the joints place a skinned mesh.
    if (skinned) {
      if (!node.instances.empty())
        notes_.add("instances-ignored",
                   "/nodes/" + std::to_string(node_index) + "/extensions/EXT_mesh_gpu_instancing",
                   "its mesh has a skin, which alone places it; it was drawn once");
      add_instance(std::move(*instance), node_index, glm::dmat4(1));
    } else {
      for (const glm::dmat4& place : places) {
        add_instance(*instance, node_index, world_from_model * place);
        ++instance->place;
      }
    }
  }
}

// EXT_mesh_gpu_instancing: what begins with "_" is an application's own, but some draw by a colour of that name.
void Importer::note_instances(int node_index) {
  const GltfNode& node = document_.nodes[static_cast<std::size_t>(node_index)];
  const std::string pointer = "/nodes/" + std::to_string(node_index) + "/extensions/EXT_mesh_gpu_instancing";
  for (const auto& [semantic, accessor] : node.instances) {
    const bool read = semantic == "TRANSLATION" || semantic == "ROTATION" || semantic == "SCALE";
    if (read || (semantic.starts_with('_') && !semantic.starts_with("_COLOR"))) continue;
    notes_.add("instance-attribute-ignored", pointer_below(pointer + "/attributes", semantic),
               "is no attribute of instances that is read; it was left out");
  }
}

const std::vector<glm::dmat4>& Importer::world_from_bind(int skin) {
  const auto known = skins_.find(skin);
  if (known != skins_.end()) return known->second;
  return skins_.emplace(skin, skin_transforms(document_, data_, skin, world_from_node_)).first->second;
}

std::optional<Instance> Importer::shared_primitive(const GltfPrimitiveRef& ref) {
  const auto known = shared_.find(ref);
  if (known != shared_.end()) return known->second;
  const auto instance =
      import_primitive(ref, document_.meshes[static_cast<std::size_t>(ref.mesh)].weights, nullptr);
  shared_.emplace(ref, instance);
  return instance;
}

std::optional<Instance> Importer::import_primitive(const GltfPrimitiveRef& ref,
                                                   const std::vector<double>& weights,
                                                   const std::vector<glm::dmat4>* joints) {
  check_deadline(deadline_, "import");
  if (!is_drawable(document_, ref, notes_)) return std::nullopt;
  const std::optional<int> material = material_of(primitive_of(document_, ref));
  const ContentHash source = source_of(ref, weights, joints, material);
  if (const auto known = model_.meshes.find(source); known != model_.meshes.end()) {
    const int scene_material = materials_.scene_material(material);
    const auto same = known->second.find(tangent_set_of(scene_material));
    if (same != known->second.end()) return add_shared(same->second, scene_material, ref);
  }
  check_size(ref);

  GltfVertices vertices = model_.vertices_of(ref, joints != nullptr, notes_);
  if (vertices.mesh.indices.empty()) {
    notes_.add("primitive-skipped", ref.pointer(), "has only degenerate lines or triangles and was left out");
    return std::nullopt;
  }
  apply_morph_targets(document_, data_, ref, weights, vertices.mesh, notes_);
  if (joints) apply_skin(vertices, *joints, ref.pointer() + "/attributes", notes_);

  const int scene_material = materials_.scene_material(material);
  complete_surface(vertices.mesh, scene_.materials[static_cast<std::size_t>(scene_material)], ref.pointer(),
                   notes_);
  const int tangent_set = tangent_set_of(scene_material);
  vertices.mesh.key = HashBuilder().add(source).add(std::int64_t{tangent_set}).finish();
  const auto mesh = std::make_shared<const Mesh>(std::move(vertices.mesh));
  model_.meshes[source].emplace(tangent_set, mesh);
  return add_shared(mesh, scene_material, ref);
}

Instance Importer::add_shared(const SharedMesh& mesh, int scene_material, const GltfPrimitiveRef& ref) {
  count_mesh(*mesh, ref);
  Instance instance;
  instance.mesh = static_cast<int>(scene_.meshes.size());
  instance.material = scene_material;
  scene_.meshes.push_back(mesh);
  return instance;
}

// What the material asks for beside its textures; -1: no tangents.
int Importer::tangent_set_of(int scene_material) const {
  return tangent_uv_set(scene_.materials[std::size_t(scene_material)]).value_or(-1);
}

ContentHash Importer::source_of(const GltfPrimitiveRef& ref, const std::vector<double>& weights,
                                const std::vector<glm::dmat4>* joints, std::optional<int> material) const {
  HashBuilder key;
  key.add("gltf-mesh").add(model_.bundle.hash);
  key.add(std::int64_t{ref.mesh}).add(std::int64_t{ref.primitive}).add(std::int64_t{material.value_or(-1)});
  for (const double weight : weights) key.add(weight);
  if (joints) key.add(std::as_bytes(std::span(*joints)));
  return key.finish();
}

// Before a primitive is read: it alone must not exceed what all may take.
void Importer::check_size(const GltfPrimitiveRef& ref) const {
  const GltfPrimitiveSize size = primitive_size(document_, ref);
  if (size.vertices > static_cast<std::uint64_t>(limits_.max_vertices)) {
    fail(ErrorCode::kTooLarge, "more than " + std::to_string(limits_.max_vertices) + " vertices",
         ref.pointer());
  }
  if (size.elements > static_cast<std::uint64_t>(limits_.max_triangles)) {
    fail(ErrorCode::kTooLarge, "more than " + std::to_string(limits_.max_triangles) + " triangles",
         ref.pointer());
  }
  if (size.bytes > static_cast<std::uint64_t>(limits_.max_mesh_bytes)) {
    fail(ErrorCode::kTooLarge, "takes more than " + std::to_string(limits_.max_mesh_bytes) + " bytes",
         ref.pointer());
  }
}

void Importer::count_mesh(const Mesh& mesh, const GltfPrimitiveRef& ref) {
  vertices_ += static_cast<std::int64_t>(mesh.positions.size());
  mesh_bytes_ += static_cast<std::int64_t>(mesh.byte_size());
  if (vertices_ > limits_.max_vertices) {
    fail(ErrorCode::kTooLarge,
         "the model has more than " + std::to_string(limits_.max_vertices) + " vertices", ref.pointer());
  }
  if (mesh_bytes_ > limits_.max_mesh_bytes) {
    fail(ErrorCode::kTooLarge,
         "the model's meshes take more than " + std::to_string(limits_.max_mesh_bytes) + " bytes",
         ref.pointer());
  }
}

void Importer::add_instance(Instance instance, int node_index, const glm::dmat4& world_from_model) {
  const std::string pointer = "/nodes/" + std::to_string(node_index);
  const Mesh& mesh = *scene_.meshes[static_cast<std::size_t>(instance.mesh)];
  const std::size_t corners = mesh.topology == Topology::kPoints  ? 1
                              : mesh.topology == Topology::kLines ? 2
                                                                  : 3;
  elements_drawn_ += static_cast<std::int64_t>(mesh.indices.size() / corners);
  if (elements_drawn_ > limits_.max_triangles) {
    fail(ErrorCode::kTooLarge,
         "the scene draws more than " + std::to_string(limits_.max_triangles) + " triangles", pointer);
  }
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 point(corner & 1 ? mesh.bounds.max.x : mesh.bounds.min.x,
                           corner & 2 ? mesh.bounds.max.y : mesh.bounds.min.y,
                           corner & 4 ? mesh.bounds.max.z : mesh.bounds.min.z, 1);
    const glm::vec3 world(world_from_model * point);
    if (std::isfinite(world.x) && std::isfinite(world.y) && std::isfinite(world.z)) continue;
    fail(ErrorCode::kUnprocessable, "places its mesh beyond single precision", pointer);
  }
  instance.world_from_model = glm::mat4(world_from_model);
  instance.node_name = document_.nodes[static_cast<std::size_t>(node_index)].name;
  if (instance.node_name.empty()) instance.node_name = "/nodes/" + std::to_string(node_index);
  scene_.instances.push_back(std::move(instance));
}

}  // namespace

Scene import_gltf(Decoder& decoder, const ModelBundle& bundle, const ImportOptions& options,
                  const ImportLimits& limits, const Deadline& deadline) {
  return GltfModel(decoder, bundle, limits, deadline, GltfModel::Times::kOne).import(options);
}

Scene GltfModel::import(const ImportOptions& options) {
  return Importer(*state_).import(options);
}

}  // namespace furnace
