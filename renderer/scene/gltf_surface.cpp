#include "renderer/scene/gltf_surface.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "renderer/base/error.hpp"
#include "renderer/scene/mesh_needs.hpp"
#include "renderer/scene/tangents.hpp"

namespace furnace {

namespace {

// Shorter than this a direction is noise; quantised unit vectors are 1 to within a few percent.
constexpr double kLeastLength = 1e-6;

template <class V>
void keep_only(std::vector<V>& values, const std::vector<std::uint32_t>& kept) {
  if (values.empty()) return;
  std::vector<V> result;
  result.reserve(kept.size());
  for (const std::uint32_t old : kept) result.push_back(values[old]);
  values = std::move(result);
}

void drop_unused_vertices(Mesh& mesh) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> new_from_old(mesh.positions.size(), kUnused);
  for (const std::uint32_t index : mesh.indices) new_from_old[index] = 0;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t old = 0; old < new_from_old.size(); ++old) {
    if (new_from_old[old] == kUnused) continue;
    new_from_old[old] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(old);
  }
  if (kept.size() == mesh.positions.size()) return;
  for (std::uint32_t& index : mesh.indices) index = new_from_old[index];
  keep_only(mesh.positions, kept);
  keep_only(mesh.normals, kept);
  keep_only(mesh.tangents, kept);
  for (auto& uvs : mesh.uvs) keep_only(uvs, kept);
  keep_only(mesh.colors, kept);
}

bool is_direction(const glm::vec3& v) {
  const double length = glm::length(glm::dvec3(v));
  return std::isfinite(length) && length > kLeastLength;
}

glm::vec3 unit(const glm::vec3& v) {
  return glm::vec3(glm::normalize(glm::dvec3(v)));
}

// The sum of the area-weighted normals of the triangles around each vertex.
std::vector<glm::dvec3> triangle_normal_sums(const Mesh& mesh) {
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0));
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const glm::dvec3 a(mesh.positions[mesh.indices[i]]);
    const glm::dvec3 b(mesh.positions[mesh.indices[i + 1]]);
    const glm::dvec3 c(mesh.positions[mesh.indices[i + 2]]);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    for (std::size_t k = 0; k < 3; ++k) sums[mesh.indices[i + k]] += normal;
  }
  return sums;
}

void mend_normals(Mesh& mesh, const std::string& pointer, GltfNotes& notes) {
  std::vector<std::size_t> broken;
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    if (is_direction(mesh.normals[i])) {
      mesh.normals[i] = unit(mesh.normals[i]);
    } else {
      broken.push_back(i);
    }
  }
  if (broken.empty()) return;
  notes.add("normals-repaired", pointer + "/attributes/NORMAL",
            std::to_string(broken.size()) + " normals have no direction; the triangles' own were used");
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0));
  if (mesh.topology == Topology::kTriangles) sums = triangle_normal_sums(mesh);
  for (const std::size_t i : broken) {
    const double length = glm::length(sums[i]);
    const bool usable = std::isfinite(length) && length > 0;
    mesh.normals[i] = usable ? glm::vec3(sums[i] / length) : glm::vec3(0, 1, 0);
  }
}

void mend_tangents(Mesh& mesh, const std::string& pointer, GltfNotes& notes) {
  for (glm::vec4& tangent : mesh.tangents) {
    if (!is_direction(glm::vec3(tangent)) || !std::isfinite(tangent.w) || tangent.w == 0) {
      mesh.tangents.clear();
      notes.add("tangents-dropped", pointer + "/attributes/TANGENT",
                "some have no direction or sign; all were left out");
      return;
    }
    tangent = glm::vec4(unit(glm::vec3(tangent)), tangent.w < 0 ? -1.0f : 1.0f);
  }
}

void complete_normals(Mesh& mesh, const std::string& pointer, GltfNotes& notes) {
  if (!mesh.normals.empty()) return mend_normals(mesh, pointer, notes);
  // glTF 2.0, section 3.7.2.1: without normals the tangents are ignored and triangles are flat.
  mesh.tangents.clear();
  if (mesh.topology != Topology::kTriangles) return;
  generate_flat_normals(mesh);
  notes.add("normals-generated", pointer + "/attributes", "has no NORMAL; flat normals were made");
}

void complete_uv_sets(Mesh& mesh, const Material& material, const std::string& pointer, GltfNotes& notes) {
  for (const int set : fill_uv_sets(mesh, material)) {
    notes.add("uv-set-missing", pointer + "/attributes",
              "has no TEXCOORD_" + std::to_string(set) + ", which its material needs; (0, 0) was used");
  }
}

void complete_tangents(Mesh& mesh, const Material& material, const std::string& pointer, GltfNotes& notes) {
  if (make_tangents(mesh, material))
    notes.add("tangents-generated", pointer + "/attributes",
              "has no TANGENT, which its material needs; MikkTSpace tangents were made");
}

void find_bounds(Mesh& mesh, const std::string& pointer) {
  mesh.bounds = Bounds();
  for (const glm::vec3& position : mesh.positions) {
    if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z)) {
      fail(ErrorCode::kUnprocessable, "has a position that is not finite", pointer + "/attributes/POSITION");
    }
    mesh.bounds.add(position);
  }
}

}  // namespace

void complete_surface(Mesh& mesh, const Material& material, const std::string& pointer, GltfNotes& notes) {
  drop_unused_vertices(mesh);
  find_bounds(mesh, pointer);
  complete_normals(mesh, pointer, notes);
  mend_tangents(mesh, pointer, notes);
  complete_uv_sets(mesh, material, pointer, notes);
  complete_tangents(mesh, material, pointer, notes);
}

}  // namespace furnace
