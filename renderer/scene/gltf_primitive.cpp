#include "renderer/scene/gltf_primitive.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_draco.hpp"
#include "renderer/scene/gltf_topology.hpp"

namespace furnace {

namespace {

// Component types with and without `normalized`, as bits.
enum Format : unsigned {
  kI8 = 1,
  kI8n = 2,
  kU8 = 4,
  kU8n = 8,
  kI16 = 16,
  kI16n = 32,
  kU16 = 64,
  kU16n = 128,
  kF32 = 256,
  kU32 = 512,
};

Format format_of(const GltfAccessor& accessor) {
  switch (accessor.component) {
    case ComponentType::kByte:
      return accessor.normalized ? kI8n : kI8;
    case ComponentType::kUnsignedByte:
      return accessor.normalized ? kU8n : kU8;
    case ComponentType::kShort:
      return accessor.normalized ? kI16n : kI16;
    case ComponentType::kUnsignedShort:
      return accessor.normalized ? kU16n : kU16;
    case ComponentType::kUnsignedInt:
      return kU32;
    case ComponentType::kFloat:
      return kF32;
  }
  return kF32;
}

constexpr unsigned bit(ElementType type) {
  return 1u << static_cast<unsigned>(type);
}

// glTF 2.0, section 3.7.2, and what KHR_mesh_quantization adds to it.
struct AttributeRule {
  std::string_view semantic;  // a trailing '_' stands for any set number
  unsigned types;
  unsigned formats;
  unsigned quantized_formats;
};

constexpr unsigned kAnyInteger = kI8 | kI8n | kU8 | kU8n | kI16 | kI16n | kU16 | kU16n;

constexpr std::array<AttributeRule, 7> kAttributeRules{{
    {"POSITION", bit(ElementType::kVec3), kF32, kAnyInteger},
    {"NORMAL", bit(ElementType::kVec3), kF32, kI8n | kI16n},
    {"TANGENT", bit(ElementType::kVec4), kF32, kI8n | kI16n},
    {"TEXCOORD_", bit(ElementType::kVec2), kF32 | kU8n | kU16n, kI8 | kI8n | kU8 | kI16 | kI16n | kU16},
    {"COLOR_", bit(ElementType::kVec3) | bit(ElementType::kVec4), kF32 | kU8n | kU16n, 0},
    {"JOINTS_", bit(ElementType::kVec4), kU8 | kU16, 0},
    {"WEIGHTS_", bit(ElementType::kVec4), kF32 | kU8n | kU16n, 0},
}};

constexpr std::array<AttributeRule, 5> kTargetRules{{
    {"POSITION", bit(ElementType::kVec3), kF32, kI8 | kI8n | kI16 | kI16n},
    {"NORMAL", bit(ElementType::kVec3), kF32, kI8n | kI16n},
    {"TANGENT", bit(ElementType::kVec3), kF32, kI8n | kI16n},
    {"TEXCOORD_", bit(ElementType::kVec2), kF32 | kI8n | kU8n | kI16n | kU16n, kI8 | kI16},
    {"COLOR_", bit(ElementType::kVec3) | bit(ElementType::kVec4), kF32 | kI8n | kU8n | kI16n | kU16n, 0},
}};

bool matches(const AttributeRule& rule, std::string_view semantic) {
  if (rule.semantic.back() != '_') return semantic == rule.semantic;
  constexpr std::size_t kMaxDigits = 4;
  return semantic.starts_with(rule.semantic) && semantic.size() > rule.semantic.size() &&
         semantic.size() <= rule.semantic.size() + kMaxDigits;
}

template <std::size_t N>
void check_attributes(const GltfDocument& document, const GltfAttributes& attributes,
                      const std::array<AttributeRule, N>& rules, std::uint64_t count,
                      const std::string& pointer) {
  for (const auto& [semantic, index] : attributes) {
    const auto rule = std::find_if(rules.begin(), rules.end(),
                                   [&name = semantic](const AttributeRule& r) { return matches(r, name); });
    if (rule == rules.end()) continue;  // application-specific: never read
    const GltfAccessor& accessor = document.accessors[static_cast<std::size_t>(index)];
    const unsigned formats = rule->formats | (document.quantized ? rule->quantized_formats : 0);
    if (!(bit(accessor.type) & rule->types) || !(format_of(accessor) & formats)) {
      fail(ErrorCode::kUnprocessable,
           "accessor " + std::to_string(index) + " has a type, component type or normalisation that " +
               semantic + " does not take",
           pointer + "/" + semantic);
    }
    if (accessor.count != count) {
      fail(ErrorCode::kUnprocessable,
           "has " + std::to_string(accessor.count) + " elements where POSITION has " + std::to_string(count),
           pointer + "/" + semantic);
    }
  }
}

void check_indices(const GltfDocument& document, const GltfPrimitive& primitive, const std::string& pointer) {
  if (!primitive.indices) return;
  const GltfAccessor& accessor = document.accessors[static_cast<std::size_t>(*primitive.indices)];
  if (accessor.type != ElementType::kScalar || !(format_of(accessor) & (kU8 | kU16 | kU32))) {
    fail(ErrorCode::kUnprocessable, "must be an accessor of unsigned SCALARs, not normalized",
         pointer + "/indices");
  }
  if (!accessor.buffer_view) return;
  const GltfBufferView& view = document.buffer_views[static_cast<std::size_t>(*accessor.buffer_view)];
  if (view.byte_stride != 0 && view.byte_stride != component_bytes(accessor.component)) {
    fail(ErrorCode::kUnprocessable, "must be tightly packed: its bufferView has a byteStride",
         pointer + "/indices");
  }
}

std::optional<int> find_attribute(const GltfPrimitive& primitive, const std::string& semantic) {
  const auto found = primitive.attributes.find(semantic);
  return found == primitive.attributes.end() ? std::nullopt : std::optional(found->second);
}

constexpr int kMaxJointSets = 16;  // 64 joints to a vertex; real files have one or two sets

void check_influences(const GltfPrimitive& primitive, const std::string& pointer) {
  for (int set = 0;; ++set) {
    const std::string number = std::to_string(set);
    const bool joints = primitive.attributes.contains("JOINTS_" + number);
    const bool weights = primitive.attributes.contains("WEIGHTS_" + number);
    if (joints != weights) {
      fail(ErrorCode::kUnprocessable, "has JOINTS_" + number + " or WEIGHTS_" + number + " without the other",
           pointer + "/attributes");
    }
    if (!joints) return;
    if (set >= kMaxJointSets) {
      fail(ErrorCode::kTooLarge, "has more than " + std::to_string(kMaxJointSets) + " sets of joints",
           pointer + "/attributes");
    }
  }
}

std::uint64_t vertex_count(const GltfDocument& document, const GltfPrimitive& primitive) {
  return document.accessors[static_cast<std::size_t>(primitive.attributes.at("POSITION"))].count;
}

std::uint64_t index_count(const GltfDocument& document, const GltfPrimitive& primitive) {
  return primitive.indices ? document.accessors[static_cast<std::size_t>(*primitive.indices)].count
                           : vertex_count(document, primitive);
}

template <class V>
bool is_finite(const V& v) {
  for (int i = 0; i < V::length(); ++i) {
    if (!std::isfinite(v[i])) return false;
  }
  return true;
}

template <class V>
void mend(std::vector<V>& values, const V& replacement, const std::string& pointer, GltfNotes& notes) {
  for (V& value : values) {
    if (is_finite(value)) continue;
    value = replacement;
    notes.add("attribute-repaired", pointer, "has values that are not finite; neutral ones were used");
  }
}

// One attribute, from the compressed mesh or from its accessor.
template <class V>
std::vector<V> read_vectors(const GltfData& data, const GltfPrimitive& primitive,
                            const DecodedPrimitive& decoded, const std::string& semantic, V fill = V(0)) {
  const auto accessor = find_attribute(primitive, semantic);
  return accessor ? data.read_vectors<V>(*accessor, fill, decoded.attribute(semantic)) : std::vector<V>();
}

void read_attributes(const GltfData& data, const GltfPrimitive& primitive, const DecodedPrimitive& decoded,
                     const std::string& pointer, Mesh& mesh, GltfNotes& notes) {
  mesh.positions = read_vectors<glm::vec3>(data, primitive, decoded, "POSITION");
  mesh.normals = read_vectors<glm::vec3>(data, primitive, decoded, "NORMAL");
  mesh.tangents = read_vectors<glm::vec4>(data, primitive, decoded, "TANGENT");
  for (std::size_t set = 0; set < mesh.uvs.size(); ++set) {
    const std::string semantic = "TEXCOORD_" + std::to_string(set);
    mesh.uvs[set] = read_vectors<glm::vec2>(data, primitive, decoded, semantic);
    mend(mesh.uvs[set], glm::vec2(0), pointer + "/" + semantic, notes);
  }
  mesh.colors = read_vectors<glm::vec4>(data, primitive, decoded, "COLOR_0", glm::vec4(1));
  mend(mesh.colors, glm::vec4(1), pointer + "/COLOR_0", notes);
}

std::vector<GltfVertices::Influences> read_influences(const GltfData& data, const GltfPrimitive& primitive,
                                                      const DecodedPrimitive& decoded) {
  std::vector<GltfVertices::Influences> result;
  for (int set = 0; primitive.attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
    const std::string joints = "JOINTS_" + std::to_string(set), weights = "WEIGHTS_" + std::to_string(set);
    result.push_back({data.read_joints(primitive.attributes.at(joints), decoded.attribute(joints)),
                      read_vectors<glm::vec4>(data, primitive, decoded, weights)});
  }
  return result;
}

std::vector<std::uint32_t> read_indices(const GltfData& data, const GltfPrimitive& primitive,
                                        std::size_t vertices, const std::string& pointer) {
  std::vector<std::uint32_t> indices;
  if (!primitive.indices) {
    indices.resize(vertices);
    for (std::size_t i = 0; i < vertices; ++i) indices[i] = static_cast<std::uint32_t>(i);
    return indices;
  }
  indices = data.read_indices(*primitive.indices);
  const std::size_t bytes = component_bytes(data.accessor(*primitive.indices).component);
  const auto restart = static_cast<std::uint32_t>((std::uint64_t{1} << (8 * bytes)) - 1);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < vertices && indices[i] != restart) continue;
    fail(ErrorCode::kUnprocessable,
         "index number " + std::to_string(i) + " is " + std::to_string(indices[i]) +
             (indices[i] == restart ? ", the primitive restart value, which glTF forbids"
                                    : "; there are " + std::to_string(vertices) + " vertices"),
         pointer + "/indices");
  }
  return indices;
}

}  // namespace

const GltfPrimitive& primitive_of(const GltfDocument& document, const GltfPrimitiveRef& ref) {
  return document.meshes[static_cast<std::size_t>(ref.mesh)]
      .primitives[static_cast<std::size_t>(ref.primitive)];
}

void check_primitive(const GltfDocument& document, const GltfPrimitiveRef& ref) {
  const GltfPrimitive& primitive = primitive_of(document, ref);
  const std::string pointer = ref.pointer();
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return;
  const std::uint64_t count = vertex_count(document, primitive);
  check_attributes(document, primitive.attributes, kAttributeRules, count, pointer + "/attributes");
  for (std::size_t i = 0; i < primitive.targets.size(); ++i) {
    check_attributes(document, primitive.targets[i], kTargetRules, count,
                     pointer + "/targets/" + std::to_string(i));
  }
  check_indices(document, primitive, pointer);
  check_influences(primitive, pointer);
}

bool is_drawable(const GltfDocument& document, const GltfPrimitiveRef& ref, GltfNotes& notes) {
  const GltfPrimitive& primitive = primitive_of(document, ref);
  if (!primitive.attributes.contains("POSITION")) {
    notes.add("primitive-skipped", ref.pointer() + "/attributes", "has no POSITION and was left out");
    return false;
  }
  if (primitive_size(document, ref).elements == 0) {
    notes.add("primitive-skipped", ref.pointer(), "has too few vertices for its mode and was left out");
    return false;
  }
  return true;
}

GltfPrimitiveSize primitive_size(const GltfDocument& document, const GltfPrimitiveRef& ref) {
  const GltfPrimitive& primitive = primitive_of(document, ref);
  GltfPrimitiveSize size;
  size.vertices = vertex_count(document, primitive);
  size.elements = element_count(primitive.mode, index_count(document, primitive));
  const std::uint64_t corners = size.elements * 3;
  // Without normals every triangle gets vertices of its own.
  const bool flat = is_triangle_mode(primitive.mode) && !primitive.attributes.contains("NORMAL");
  size.vertices = std::max(size.vertices, flat ? corners : 0);
  size.bytes =
      size.vertices * (2 * sizeof(glm::vec3) + 2 * sizeof(glm::vec2) + 2 * sizeof(glm::vec4)) + corners * 4;
  return size;
}

GltfVertices read_primitive_vertices(const GltfDocument& document, const GltfData& data,
                                     const GltfPrimitiveRef& ref, bool with_influences, GltfNotes& notes) {
  const GltfPrimitive& primitive = primitive_of(document, ref);
  const std::string pointer = ref.pointer();
  DecodedPrimitive decoded = decode_primitive(document, data, ref);
  GltfVertices vertices;
  vertices.mesh.name = document.meshes[static_cast<std::size_t>(ref.mesh)].name;
  read_attributes(data, primitive, decoded, pointer + "/attributes", vertices.mesh, notes);
  if (with_influences) vertices.influences = read_influences(data, primitive, decoded);
  if (primitive.draco) {
    constexpr int kTriangles = 4;
    vertices.mesh.indices = expand_topology(kTriangles, std::move(decoded.indices));
    return vertices;
  }

  std::vector<std::uint32_t> indices = read_indices(data, primitive, vertices.mesh.positions.size(), pointer);
  if (has_left_over(primitive.mode, indices.size())) {
    notes.add("primitive-incomplete", pointer, "ends within a line or triangle; the rest was left out");
  }
  vertices.mesh.topology = topology_of(primitive.mode);
  vertices.mesh.indices = expand_topology(primitive.mode, std::move(indices));
  return vertices;
}

}  // namespace furnace
