#include "renderer/scene/procedural.hpp"

#include "renderer/scene/lathe.hpp"
#include "renderer/scene/shader_ball.hpp"
#include "renderer/scene/transform.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace furnace {
namespace {

// Silhouettes that stay round at 1024 px: 144 segments leave 0.1 px between chord and circle.
constexpr int kSegments = 144;

Mesh closed(Mesh mesh) {
  mesh.bounds = {};
  for (const glm::vec3& position : mesh.positions) mesh.bounds.add(position);
  return mesh;
}

// A unit square around `centre` whose texture stands upright when seen against `normal` with `tangent` to the
// right.
void add_square(Mesh& mesh, const glm::vec3& centre, const glm::vec3& normal, const glm::vec3& tangent) {
  const glm::vec3 up = glm::cross(normal, tangent);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec2 uv : {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)}) {
    mesh.positions.push_back(centre + (uv.x - 0.5f) * tangent + (0.5f - uv.y) * up);
    mesh.normals.push_back(normal);
    mesh.tangents.emplace_back(tangent, 1);
    mesh.uvs[0].push_back(uv);
  }
  for (const std::uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + corner);
}

// A disc around the Y axis that closes a turned side: its rim takes the positions of the side's ring
// `first_ring_vertex`.
void add_cap(Mesh& mesh, std::uint32_t first_ring_vertex, float height, float facing) {
  const auto centre = static_cast<std::uint32_t>(mesh.positions.size());
  const auto add_vertex = [&](const glm::vec3& position) {
    mesh.positions.push_back(position);
    mesh.normals.emplace_back(0, facing, 0);
    mesh.tangents.emplace_back(1, 0, 0, 1);
    mesh.uvs[0].emplace_back(0.5f + position.x, 0.5f + facing * position.z);
  };
  add_vertex({0, height, 0});
  for (int j = 0; j < kSegments; ++j) {
    const glm::vec3 rim = mesh.positions[first_ring_vertex + j];
    add_vertex(rim);
  }
  for (std::uint32_t j = 0; j < kSegments; ++j) {
    const std::uint32_t here = centre + 1 + j, next = centre + 1 + (j + 1) % kSegments;
    mesh.indices.insert(mesh.indices.end(), {centre, facing > 0 ? here : next, facing > 0 ? next : here});
  }
}

std::vector<Mesh> make_sphere() {
  Profile profile({0, 0.5, 0});
  // In two halves, so that the equator is exactly 1 m wide.
  profile.turn(0.5, kPi / 2).turn(0.5, kPi);
  return {lathe("sphere", profile, kSegments)};
}

std::vector<Mesh> make_cube() {
  Mesh mesh;
  mesh.name = "cube";
  using Axes = std::pair<glm::vec3, glm::vec3>;  // normal, tangent
  for (const auto& [normal, tangent] :
       {Axes{{1, 0, 0}, {0, 0, -1}}, Axes{{-1, 0, 0}, {0, 0, 1}}, Axes{{0, 1, 0}, {1, 0, 0}},
        Axes{{0, -1, 0}, {1, 0, 0}}, Axes{{0, 0, 1}, {1, 0, 0}}, Axes{{0, 0, -1}, {-1, 0, 0}}})
    add_square(mesh, 0.5f * normal, normal, tangent);
  return {closed(std::move(mesh))};
}

std::vector<Mesh> make_plane() {
  Mesh mesh;
  mesh.name = "plane";
  add_square(mesh, glm::vec3(0), {0, 1, 0}, {1, 0, 0});
  return {closed(std::move(mesh))};
}

std::vector<Mesh> make_cylinder() {
  Profile side({0.5, 0.5, kPi / 2});
  side.forward(1);
  Mesh mesh = lathe("cylinder", side, kSegments);
  add_cap(mesh, 0, 0.5f, 1);
  add_cap(mesh, kSegments + 1, -0.5f, -1);
  return {closed(std::move(mesh))};
}

std::vector<Mesh> make_torus() {
  // The tube starts at its innermost point, where the seam is least seen.
  Profile tube({0.2, 0, -kPi / 2});
  tube.turn(0.15, kPi / 2).turn(0.15, 3 * kPi / 2).close();
  return {lathe("torus", tube, kSegments)};
}

struct Builtin {
  std::string_view name;
  std::vector<Mesh> (*make)();
};

constexpr std::array kBuiltins = {
    Builtin{"sphere", make_sphere}, Builtin{"cube", make_cube},
    Builtin{"plane", make_plane},   Builtin{"cylinder", make_cylinder},
    Builtin{"torus", make_torus},   Builtin{"shader-ball", make_shader_ball},
};

Material neutral(std::string_view name, float albedo, float metallic, float perceptual_roughness) {
  Material material;
  material.name = name;
  material.base_color = {albedo, albedo, albedo, 1};
  material.metallic = metallic;
  material.perceptual_roughness = perceptual_roughness;
  return material;
}

}  // namespace

std::optional<std::vector<Mesh>> builtin_mesh(std::string_view name) {
  const auto builtin =
      std::find_if(kBuiltins.begin(), kBuiltins.end(), [&](const Builtin& b) { return b.name == name; });
  if (builtin == kBuiltins.end()) return std::nullopt;
  return builtin->make();
}

std::vector<std::string_view> builtin_mesh_names() {
  std::vector<std::string_view> names;
  for (const Builtin& builtin : kBuiltins) names.push_back(builtin.name);
  return names;
}

std::optional<Material> builtin_part_material(std::string_view part_name) {
  if (part_name == "core") return neutral("shader-ball core", 0.45f, 1, 0.30f);
  if (part_name == "base") return neutral("shader-ball base", 0.045f, 0, 0.38f);
  return std::nullopt;
}

}  // namespace furnace
