// Meshes, skins, cameras, nodes and scenes. The node hierarchy is checked without recursion.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <glm/gtc/type_ptr.hpp>

#include "renderer/scene/gltf_read.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {

namespace {

GltfAttributes read_attributes(const JsonObject& json, const GltfCounts& counts) {
  GltfAttributes attributes;
  for (const std::string& semantic : json.keys()) {
    attributes[semantic] = json.required_reference(semantic, "accessor", counts.accessors);
  }
  return attributes;
}

std::map<int, int> read_variant_materials(const JsonObject& primitive, const GltfCounts& counts) {
  std::map<int, int> materials;
  const auto json = primitive.extension("KHR_materials_variants");
  if (!json) return materials;
  json->each("mappings", [&](const JsonObject& mapping) {
    const int material = mapping.required_reference("material", "material", counts.materials);
    for (const int variant : mapping.references("variants", "variant", counts.variants))
      materials.emplace(variant, material);
  });
  return materials;
}

GltfPrimitive read_primitive(const JsonObject& json, const GltfCounts& counts) {
  GltfPrimitive primitive;
  primitive.attributes = read_attributes(json.required_object("attributes"), counts);
  primitive.indices = json.reference("indices", "accessor", counts.accessors);
  primitive.material = json.reference("material", "material", counts.materials);
  primitive.variant_materials = read_variant_materials(json, counts);
  const std::uint64_t mode = json.integer("mode", 4);
  if (mode > 6) json.refuse("mode", "must be 0 to 6");
  primitive.mode = static_cast<int>(mode);
  primitive.draco = read_draco(json, primitive.attributes, primitive.mode, counts);
  json.each("targets",
            [&](const JsonObject& target) { primitive.targets.push_back(read_attributes(target, counts)); });
  return primitive;
}

double positive(const JsonObject& json, std::string_view key) {
  const double value = json.required_number(key);
  if (!(value > 0)) json.refuse(key, "must be greater than 0");
  return value;
}

void read_perspective(const JsonObject& json, CameraNode& camera) {
  camera.fov_y_rad = positive(json, "yfov");
  if (camera.fov_y_rad >= kPi) json.refuse("yfov", "must be less than pi");
  if (json.has("aspectRatio")) camera.aspect_ratio = positive(json, "aspectRatio");
  camera.z_near = positive(json, "znear");
  if (!json.has("zfar")) return;
  camera.z_far = positive(json, "zfar");
  if (*camera.z_far <= camera.z_near) json.refuse("zfar", "must be greater than znear");
}

void read_orthographic(const JsonObject& json, CameraNode& camera) {
  camera.orthographic = true;
  camera.half_width = std::abs(json.required_number("xmag"));
  camera.half_height = std::abs(json.required_number("ymag"));
  if (camera.half_width == 0) json.refuse("xmag", "must not be 0");
  if (camera.half_height == 0) json.refuse("ymag", "must not be 0");
  camera.z_near = json.required_number("znear");
  if (camera.z_near < 0) json.refuse("znear", "must not be negative");
  camera.z_far = positive(json, "zfar");
  if (*camera.z_far <= camera.z_near) json.refuse("zfar", "must be greater than znear");
}

void read_transform(const JsonObject& json, GltfNode& node) {
  const auto matrix = json.vector<16>("matrix");
  const auto translation = json.vector<3>("translation");
  const auto rotation = json.vector<4>("rotation");
  const auto scale = json.vector<3>("scale");
  if (matrix) {
    if (translation || rotation || scale) json.refuse("matrix", "excludes translation, rotation and scale");
    node.matrix = glm::make_mat4(matrix->data());
    constexpr double kRounding = 1e-5;  // of exporters that multiply single-precision matrices
    for (int column = 0; column < 4; ++column) {
      double& last = (*node.matrix)[column][3];
      const double exact = column == 3 ? 1 : 0;
      if (std::abs(last - exact) > kRounding)
        json.refuse("matrix", "must be affine: its fourth row must be 0 0 0 1");
      last = exact;
    }
    return;
  }
  if (translation) node.translation = glm::make_vec3(translation->data());
  if (scale) node.scale = glm::make_vec3(scale->data());
  if (!rotation) return;
  const auto& [x, y, z, w] = *rotation;
  node.rotation = glm::dquat(w, x, y, z);
  const double length = glm::length(node.rotation);
  if (!(length > 1e-6) || !std::isfinite(length)) json.refuse("rotation", "must be a unit quaternion");
}

int parent_within_a_cycle(const std::vector<GltfNode>& nodes, int node) {
  std::vector<bool> seen(nodes.size(), false);
  while (!seen[static_cast<std::size_t>(node)]) {
    seen[static_cast<std::size_t>(node)] = true;
    node = nodes[static_cast<std::size_t>(node)].parent;
  }
  return node;
}

}  // namespace

GltfMesh read_mesh(const JsonObject& json, const GltfCounts& counts) {
  GltfMesh mesh;
  mesh.name = json.string("name");
  if (!json.has("primitives")) json.refuse("primitives", "is required");
  json.each("primitives", [&](const JsonObject& primitive) {
    mesh.primitives.push_back(read_primitive(primitive, counts));
  });
  mesh.weights = json.numbers("weights");
  const std::size_t targets = mesh.primitives.empty() ? 0 : mesh.primitives.front().targets.size();
  for (const GltfPrimitive& primitive : mesh.primitives) {
    if (primitive.targets.size() != targets) {
      json.refuse("primitives", "must all have the same number of morph targets");
    }
  }
  if (!mesh.weights.empty() && mesh.weights.size() != targets) {
    json.refuse("weights", "must have one number per morph target, " + std::to_string(targets));
  }
  return mesh;
}

GltfSkin read_skin(const JsonObject& json, const GltfCounts& counts) {
  GltfSkin skin;
  if (!json.has("joints")) json.refuse("joints", "is required");
  skin.joints = json.references("joints", "node", counts.nodes);
  skin.inverse_bind_matrices = json.reference("inverseBindMatrices", "accessor", counts.accessors);
  return skin;
}

CameraNode read_camera(const JsonObject& json) {
  CameraNode camera;
  camera.name = json.string("name");
  const std::string type = json.required_string("type");
  if (type == "perspective") {
    read_perspective(json.required_object("perspective"), camera);
  } else if (type == "orthographic") {
    read_orthographic(json.required_object("orthographic"), camera);
  } else {
    json.refuse("type", "must be perspective or orthographic");
  }
  return camera;
}

// KHR_lights_punctual. Some exporters write equal cones for a hard edge, and a range of 0 for none.
std::optional<Light> read_light(const JsonObject& json, std::vector<Note>& notes) {
  Light light;
  light.name = json.string("name");
  const std::string type = json.required_string("type");
  if (type == "directional") {
    light.kind = LightKind::kDirectional;
  } else if (type == "spot") {
    light.kind = LightKind::kSpot;
    if (!json.has("spot")) json.refuse("spot", "is required");
    const JsonObject spot = json.required_object("spot");
    light.inner_cone_rad = spot.number("innerConeAngle", 0);
    light.outer_cone_rad = spot.number("outerConeAngle", kPi / 4);
    if (!(light.outer_cone_rad > 0)) spot.refuse("outerConeAngle", "must be greater than 0");
    if (light.outer_cone_rad > kPi / 2) {
      light.outer_cone_rad = kPi / 2;
      notes.push_back(
          {"value-clamped", spot.pointer_to("outerConeAngle"), "is more than pi / 2, which was taken"});
    }
    if (!(light.inner_cone_rad >= 0)) spot.refuse("innerConeAngle", "must not be negative");
    if (light.inner_cone_rad >= light.outer_cone_rad) {
      light.inner_cone_rad = light.outer_cone_rad;
      notes.push_back({"value-clamped", spot.pointer_to("innerConeAngle"),
                       "is not less than outerConeAngle; the edge is hard"});
    }
  } else if (type != "point") {
    return std::nullopt;
  }
  const double intensity = json.number("intensity", 1);
  constexpr double kBrightest = 1e12;  // lux or candela, of each colour: beyond, pictures would overflow
  if (!(intensity >= 0 && intensity <= kBrightest)) json.refuse("intensity", "must be 0 to 1e12");
  light.intensity = glm::dvec3(intensity);
  if (const auto color = json.vector<3>("color")) {
    for (int c = 0; c < 3; ++c) {
      if (!((*color)[std::size_t(c)] >= 0)) json.refuse("color", "must not be negative");
      light.intensity[c] = std::min(light.intensity[c] * (*color)[std::size_t(c)], kBrightest);
    }
  }
  if (json.has("range") && json.required_number("range") == 0) {
    notes.push_back({"value-clamped", json.pointer_to("range"), "is 0; the light has no limit"});
  } else if (json.has("range")) {
    light.range_m = positive(json, "range");
  }
  return light;
}

GltfNode read_node(const JsonObject& json, const GltfCounts& counts) {
  GltfNode node;
  node.name = json.string("name");
  node.children = json.references("children", "node", counts.nodes);
  node.mesh = json.reference("mesh", "mesh", counts.meshes);
  node.skin = json.reference("skin", "skin", counts.skins);
  node.camera = json.reference("camera", "camera", counts.cameras);
  if (const auto lights = json.extension("KHR_lights_punctual"))
    node.light = lights->required_reference("light", "light", counts.lights);
  node.weights = json.numbers("weights");
  if (const auto visibility = json.extension("KHR_node_visibility"))
    node.visible = visibility->boolean("visible", true);
  if (const auto instancing = json.extension("EXT_mesh_gpu_instancing"))
    node.instances = read_attributes(instancing->required_object("attributes"), counts);
  read_transform(json, node);
  return node;
}

void link_nodes(std::vector<GltfNode>& nodes, const ImportLimits& limits) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = 0; j < nodes[i].children.size(); ++j) {
      GltfNode& child = nodes[static_cast<std::size_t>(nodes[i].children[j])];
      if (child.parent >= 0) {
        fail(ErrorCode::kUnprocessable, "is already a child of node " + std::to_string(child.parent),
             "/nodes/" + std::to_string(i) + "/children/" + std::to_string(j));
      }
      child.parent = static_cast<int>(i);
    }
  }

  std::vector<std::pair<int, int>> open;  // node, depth
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent < 0) open.emplace_back(static_cast<int>(i), 1);
  }
  std::vector<bool> reached(nodes.size(), false);
  while (!open.empty()) {
    const auto [index, depth] = open.back();
    open.pop_back();
    if (depth > limits.max_node_depth) {
      fail(ErrorCode::kTooLarge, "the node hierarchy is deeper than " + std::to_string(limits.max_node_depth),
           "/nodes/" + std::to_string(index));
    }
    reached[static_cast<std::size_t>(index)] = true;
    for (const int child : nodes[static_cast<std::size_t>(index)].children)
      open.emplace_back(child, depth + 1);
  }
  const auto missed = std::find(reached.begin(), reached.end(), false);
  if (missed != reached.end()) {
    const int node = parent_within_a_cycle(nodes, static_cast<int>(missed - reached.begin()));
    fail(ErrorCode::kUnprocessable, "is its own ancestor", "/nodes/" + std::to_string(node));
  }
}

GltfScene read_scene(const JsonObject& json, const std::vector<GltfNode>& nodes) {
  GltfScene scene;
  scene.nodes = json.references("nodes", "node", static_cast<int>(nodes.size()));
  std::set<int> seen;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const int node = scene.nodes[i];
    const std::string pointer = json.pointer_to("nodes") + "/" + std::to_string(i);
    if (nodes[static_cast<std::size_t>(node)].parent >= 0) {
      fail(ErrorCode::kUnprocessable, "node " + std::to_string(node) + " is not a root", pointer);
    }
    if (!seen.insert(node).second) {
      fail(ErrorCode::kUnprocessable, "node " + std::to_string(node) + " is listed twice", pointer);
    }
  }
  return scene;
}

}  // namespace furnace
