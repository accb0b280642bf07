// One primitive of a glTF mesh, as the file has it: formats checked, attributes decoded, topology expanded.
#pragma once

#include <string>
#include <vector>

#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_notes.hpp"

namespace furnace {

struct GltfPrimitiveRef {
  int mesh = 0;
  int primitive = 0;

  std::string pointer() const {
    return "/meshes/" + std::to_string(mesh) + "/primitives/" + std::to_string(primitive);
  }
  auto operator<=>(const GltfPrimitiveRef&) const = default;
};

// Attributes in the mesh's own space; `influences` hold JOINTS_n and WEIGHTS_n when they are wanted.
struct GltfVertices {
  struct Influences {
    std::vector<glm::uvec4> joints;
    std::vector<glm::vec4> weights;
  };

  Mesh mesh;
  std::vector<Influences> influences;
};

// What a primitive will take, known before anything of it is read.
struct GltfPrimitiveSize {
  std::uint64_t vertices = 0;
  std::uint64_t elements = 0;  // points, lines or triangles
  std::uint64_t bytes = 0;     // of the finished mesh, at most
};

const GltfPrimitive& primitive_of(const GltfDocument& document, const GltfPrimitiveRef& ref);

// Checks types, component types and counts of every accessor the primitive and its morph targets name.
// Errors: kUnprocessable at the attribute.
void check_primitive(const GltfDocument& document, const GltfPrimitiveRef& ref);

// False, with a note, for a primitive that draws nothing. Needs check_primitive.
bool is_drawable(const GltfDocument& document, const GltfPrimitiveRef& ref, GltfNotes& notes);
GltfPrimitiveSize primitive_size(const GltfDocument& document, const GltfPrimitiveRef& ref);

// Errors: kUnprocessable for an index that is out of range.
GltfVertices read_primitive_vertices(const GltfDocument& document, const GltfData& data,
                                     const GltfPrimitiveRef& ref, bool with_influences, GltfNotes& notes);

}  // namespace furnace
