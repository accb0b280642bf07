// Geometry of a model's part as decoders of OBJ, STL and PLY give it, made fit: equal vertices are one, triangles have normals.
#pragma once

#include "renderer/scene/scene.hpp"

namespace furnace {

// Vertices with the same bits in every attribute become one, in order of their first use; what no index names goes.
void weld_vertices(Mesh& mesh);

// Gives each corner of a triangle mesh the mean of the normals of the triangles that meet there, weighted by their angles,
// of those that lean less than 45 degrees against its own: edges stay sharp. Vertices are split and welded again.
void generate_smooth_normals(Mesh& mesh);

}  // namespace furnace
