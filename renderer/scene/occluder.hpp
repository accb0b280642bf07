// Fewer triangles that cast the same shadow.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

struct OccluderLimits {
  double error = 0;       // of the surface against the original, over the mesh's extent
  std::size_t share = 1;  // of the triangles one of so many is enough
};
// The ground is away from most of what it is shadowed by; a surface lies next to what shadows it: less than a texel of a map
// with 512 of them.
inline constexpr OccluderLimits kGroundOccluder{1.0 / 400, 40}, kSurfaceOccluder{1.0 / 500, 40};

// Triangles over the mesh's own vertices whose surface stays near the original; all of them for a mesh that is small already.
// Vertex attributes are of no account. `mesh`: kTriangles. Pure. Threads: any.
std::vector<std::uint32_t> occluder_indices(const Mesh& mesh, const OccluderLimits& limits);

}  // namespace furnace
