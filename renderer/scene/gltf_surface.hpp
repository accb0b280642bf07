// Makes a decoded mesh fit to be shaded: no vertices that nothing names (files share one vertex buffer among
// many primitives), unit normals, and the tangents and UV sets that its material needs (mesh_needs.hpp).
#pragma once

#include <string>

#include "renderer/scene/gltf_notes.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// `pointer` is the primitive's. Notes tell of everything that was not in the file. Errors: kUnprocessable for
// a position that is not finite.
void complete_surface(Mesh& mesh, const Material& material, const std::string& pointer, GltfNotes& notes);

}  // namespace furnace
