// A glTF 2.0 document as typed values: types, references, ranges of accessors and the node hierarchy are
// sound once it is read. What no picture needs (extras, unknown extensions) is not here.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "renderer/base/blob.hpp"
#include "renderer/scene/gltf_container.hpp"
#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/material.hpp"
#include "renderer/scene/meshopt_decode.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

enum class ComponentType : std::uint16_t {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126,
};
enum class ElementType : std::uint8_t { kScalar, kVec2, kVec3, kVec4, kMat2, kMat3, kMat4 };

std::size_t component_bytes(ComponentType type);
int component_count(ElementType type);
std::size_t element_bytes(ElementType type, ComponentType component);
// Bytes from the first element to the end of the last: `count` elements `stride` bytes apart.
std::uint64_t span_bytes(std::uint64_t count, std::uint64_t stride, ElementType type,
                         ComponentType component);  // with the column padding of small matrices

// Zeros cost nothing in the file: without a bound a few hundred bytes could ask for gigabytes.
inline constexpr std::uint64_t kMaxImpliedElements = 1 << 22;

struct GltfBuffer {
  std::string uri;  // as written; empty: the BIN chunk, or nothing
  bool has_uri = false;
  bool is_fallback = false;  // for readers without meshopt: nothing of it is used
  std::uint64_t byte_length = 0;
};

// EXT_meshopt_compression, KHR_meshopt_compression: where a view's bytes come from.
struct GltfMeshopt {
  int buffer = 0;
  std::uint64_t byte_offset = 0;
  std::uint64_t byte_length = 0;
  MeshoptLayout layout;  // sound, of as many bytes as the view has
  std::string pointer;
};

struct GltfBufferView {
  int buffer = 0;
  std::uint64_t byte_offset = 0;
  std::uint64_t byte_length = 0;
  std::uint64_t byte_stride = 0;  // 0: tightly packed
  std::optional<GltfMeshopt> meshopt;
};

struct GltfSparse {
  std::uint64_t count = 0;
  int indices_view = 0;
  std::uint64_t indices_offset = 0;
  ComponentType indices_type = ComponentType::kUnsignedInt;
  int values_view = 0;
  std::uint64_t values_offset = 0;
};

struct GltfAccessor {
  std::optional<int> buffer_view;  // none: zeros
  std::uint64_t byte_offset = 0;
  ComponentType component = ComponentType::kFloat;
  ElementType type = ElementType::kScalar;
  bool normalized = false;
  std::uint64_t count = 0;
  std::optional<GltfSparse> sparse;
};

struct GltfImage {
  std::string uri;  // as written
  std::optional<int> buffer_view;
};

struct GltfTexture {
  std::vector<int> images;  // the first that can be read counts: those of extensions, then the plain source
  SamplerDesc sampler;
};

struct GltfTextureRef {
  int texture = 0;
  int uv_set = 0;
  UvTransform transform;
  std::string pointer;
};

struct GltfMaterial {
  Material values;                                                   // without textures
  std::array<std::optional<GltfTextureRef>, kTextureUses> textures;  // by TextureUse
  std::vector<Note> notes;

  std::optional<GltfTextureRef>& texture(TextureUse use) { return textures[std::size_t(use)]; }
};

using GltfAttributes = std::map<std::string, int>;  // semantic -> accessor

// KHR_draco_mesh_compression: where a primitive's indices and these of its attributes are.
struct GltfDraco {
  int buffer_view = 0;
  std::map<std::string, std::uint32_t> attributes;  // semantic -> unique id in the compressed mesh
};

struct GltfPrimitive {
  GltfAttributes attributes;
  std::optional<GltfDraco> draco;
  std::optional<int> indices;
  std::optional<int> material;
  std::map<int, int> variant_materials;  // KHR_materials_variants: variant -> material
  int mode = 4;
  std::vector<GltfAttributes> targets;
};

struct GltfMesh {
  std::string name;
  std::vector<GltfPrimitive> primitives;
  std::vector<double> weights;
};

struct GltfSkin {
  std::vector<int> joints;
  std::optional<int> inverse_bind_matrices;
};

enum class GltfInterpolation : std::uint8_t { kStep, kLinear, kCubicSpline };

struct GltfAnimationSampler {
  int input = 0;   // accessor of times, s
  int output = 0;  // accessor of values
  GltfInterpolation interpolation = GltfInterpolation::kLinear;
};

struct GltfAnimationChannel {
  int sampler = 0;
  std::string target;   // JSON pointer to the property that it moves; empty: none that is known
  std::string pointer;  // of the channel's target
};

struct GltfAnimation {
  std::string name;
  std::vector<GltfAnimationSampler> samplers;
  std::vector<GltfAnimationChannel> channels;
};

struct GltfNode {
  std::string name;
  std::vector<int> children;
  int parent = -1;
  std::optional<int> mesh, skin, camera, light;
  std::vector<double> weights;
  std::optional<glm::dmat4> matrix;  // else the three below
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
  glm::dvec3 scale{1};
  bool visible = true;       // KHR_node_visibility
  GltfAttributes instances;  // EXT_mesh_gpu_instancing: TRANSLATION, ROTATION, SCALE -> accessor
};

struct GltfScene {
  std::vector<int> nodes;
};

struct GltfDocument {
  std::vector<std::string> extensions_used;
  bool quantized = false;  // KHR_mesh_quantization is among them
  std::vector<GltfBuffer> buffers;
  std::vector<GltfBufferView> buffer_views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfImage> images;
  std::vector<GltfTexture> textures;
  std::vector<GltfMaterial> materials;
  std::vector<std::string> variants;  // names
  std::vector<GltfMesh> meshes;
  std::vector<GltfSkin> skins;
  std::vector<CameraNode> cameras;  // world_from_view is the node's to fill in
  // Position and direction are the node's to fill in; none of a kind that is not known.
  std::vector<std::optional<Light>> lights;
  std::vector<Note> light_notes;
  std::vector<GltfNode> nodes;
  std::vector<GltfScene> scenes;
  std::vector<GltfAnimation> animations;
  std::optional<int> default_scene;
  std::optional<ByteRange> binary;  // the GLB's BIN chunk, in the document's bytes
};

// Errors: kUnprocessable with a pointer, kTooLarge for a limit.
GltfDocument read_gltf_document(const Blob& bytes, const ImportLimits& limits);

}  // namespace furnace
