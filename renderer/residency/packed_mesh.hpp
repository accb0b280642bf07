// A mesh's vertices in the shape the GPU takes: made by the CPU's threads, so that the GL thread only copies.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/scene.hpp"

namespace furnace {

// Rows of four floats a vertex: position (with its patch's number as bits), normal, tangent, both UV sets, and colour where
// the mesh has colours. Absent attributes are 0. Threads: a value.
struct PackedMesh {
  std::vector<glm::vec4> rows;
  std::uint32_t rows_per_vertex = 4;
};

// Errors: kTooLarge for more triangles than shaders/lib/visibility.glsl numbers. Threads: any.
PackedMesh pack_mesh(const Mesh& mesh);

}  // namespace furnace
