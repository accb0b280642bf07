// What lives inside the binary: meshes and environments made by formulas, so that the first picture needs no
// file.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "renderer/image/image.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// "sphere", "cube", "plane", "cylinder", "torus" (1 m wide, centred at the origin; the plane lies in y = 0
// and faces +Y) and "shader-ball" (0.9 m wide, stands on y = 0). Normals, tangents and UVs (v downwards)
// included; closed surfaces wind outwards. Mesh 0 takes the material that a request gives; the others
// ("core", "base" of the shader-ball) keep theirs, builtin_part_material(mesh.name).
std::optional<std::vector<Mesh>> builtin_mesh(std::string_view name);
std::vector<std::string_view> builtin_mesh_names();

// The fixed neutral material of a built-in's further parts; none for a part that takes the request's
// material.
std::optional<Material> builtin_part_material(std::string_view part_name);

// "studio", "overcast", "clear-sky", "furnace" (radiance 1 everywhere); RGB kFloat32 equirects in the
// convention of ibl/baked_environment.hpp, scaled so that exposure 0 suits them: a white Lambert plane that
// faces up shows about 1. Worked out in double and rounded to half precision, which hides the last bits in
// which math libraries differ: the bytes are the same on every machine.
std::optional<Image> builtin_environment(std::string_view name);
Image constant_environment(const glm::vec3& radiance);
std::vector<std::string_view> builtin_environment_names();

}  // namespace furnace
