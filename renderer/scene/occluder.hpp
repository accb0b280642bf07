// Fewer triangles that cast the same shadow.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

// Triangles over the mesh's own vertices whose surface stays within 1/400 of the mesh's extent of the original; all of them
// for a mesh that is small already. Vertex attributes are of no account. `mesh`: kTriangles. Pure. Threads: any.
std::vector<std::uint32_t> occluder_indices(const Mesh& mesh);

}  // namespace furnace
