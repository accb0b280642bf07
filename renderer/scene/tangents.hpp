// Tangent frames compatible with MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"), the basis that
// glTF 2.0 prescribes for normal maps when a file brings no tangents.
#pragma once

#include "renderer/scene/scene.hpp"

namespace furnace {

// Gives a triangle mesh tangents for `uvs[uv_set]`. Vertices whose corners need different frames (mirrored UVs, hard edges)
// are split and the arrays re-welded; `source_vertex` of each new vertex is returned (old index), so callers can carry
// other per-vertex data along. Degenerate triangles take the frame of a neighbour at the same vertex, else an arbitrary
// perpendicular one; never a NaN. Needs normals and that UV set.
std::vector<std::uint32_t> generate_tangents(Mesh& mesh, int uv_set);

// Smooths nothing: un-welds the mesh and gives each triangle its geometric normal (glTF 2.0: "flat normals" when none
// are given). Returns source_vertex as above.
std::vector<std::uint32_t> generate_flat_normals(Mesh& mesh);

}  // namespace furnace
