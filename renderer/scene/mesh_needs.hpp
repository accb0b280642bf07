// What a material asks of the mesh it is on: the UV sets that it samples, and tangents. Used by the importer for a file's
// own materials and by the composition for those that a request changes.
#pragma once

#include <optional>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

// The UV set whose tangent frames the material is shaded in; none: it needs no tangents.
std::optional<int> tangent_uv_set(const Material& material);

// Whether a mesh has all that the material asks for, so that neither of the two below would change it.
bool is_complete(const Mesh& mesh, const Material& material);

// Gives a mesh, as zeros, the UV sets that the material needs and the mesh lacks. Returns these sets.
std::vector<int> fill_uv_sets(Mesh& mesh, const Material& material);

// Makes tangents if the material needs them and a mesh of triangles has none; whether it did. Vertices may be split. The
// mesh has normals and all UV sets that the material needs.
bool make_tangents(Mesh& mesh, const Material& material);

}  // namespace furnace
