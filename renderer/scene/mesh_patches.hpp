// Parts of a mesh over which every attribute is continuous.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

// Per vertex the number of its patch, from 0 in order of appearance: triangles that share a vertex, directly or by others,
// are of one patch. Seams of UV, hard edges and changes of colour divide, since a file repeats vertices there.
std::vector<std::uint32_t> mesh_patches(const Mesh& mesh);

}  // namespace furnace
