#include "tests/fuzz/expectations.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/base/check.hpp"

namespace furnace::fuzz {
namespace {

template <class V>
void expect_numbers(const std::vector<V>& values, const Mesh& mesh, bool required, const char* what) {
  FURNACE_CHECK(values.size() == mesh.positions.size() || (values.empty() && !required),
                "{} {} of {} vertices", values.size(), what, mesh.positions.size());
  for (const V& value : values)
    for (int i = 0; i < V::length(); ++i) FURNACE_CHECK(std::isfinite(value[i]), "{}: {}", what, value[i]);
}

void expect_whole(const Mesh& mesh) {
  FURNACE_CHECK(!mesh.indices.empty(), "mesh \"{}\" draws nothing", mesh.name);
  const std::uint32_t last = *std::ranges::max_element(mesh.indices);
  FURNACE_CHECK(last < mesh.positions.size(), "index {} of {}", last, mesh.positions.size());
  const bool triangles = mesh.topology == Topology::kTriangles;
  const std::size_t corners = triangles ? 3 : mesh.topology == Topology::kLines ? 2 : 1;
  FURNACE_CHECK(mesh.indices.size() % corners == 0, "{} indices", mesh.indices.size());
  expect_numbers(mesh.positions, mesh, true, "positions");
  expect_numbers(mesh.normals, mesh, triangles, "normals");
  expect_numbers(mesh.tangents, mesh, false, "tangents");
  for (const auto& uvs : mesh.uvs) expect_numbers(uvs, mesh, false, "texture coordinates");
  expect_numbers(mesh.colors, mesh, false, "colours");
}

}  // namespace

ImportLimits small_import_limits() {
  ImportLimits limits;
  limits.max_triangles = limits.max_vertices = 20'000;
  limits.max_nodes = 500;
  limits.max_node_depth = 64;
  limits.max_json_bytes = 64 << 10;
  limits.max_buffer_bytes = 1 << 20;
  limits.max_instances = 1000;
  limits.max_mesh_bytes = 16 << 20;
  return limits;
}

void expect_whole(const Scene& scene) {
  FURNACE_CHECK(!scene.materials.empty(), "a scene without materials");
  for (const SharedMesh& mesh : scene.meshes) expect_whole(*mesh);
  for (const Instance& instance : scene.instances) {
    FURNACE_CHECK(std::size_t(instance.mesh) < scene.meshes.size(), "mesh {}", instance.mesh);
    FURNACE_CHECK(std::size_t(instance.material) < scene.materials.size(), "material {}", instance.material);
    FURNACE_CHECK(!instance.node_name.empty(), "an instance of mesh {} has no name", instance.mesh);
    const Mesh& mesh = *scene.meshes[std::size_t(instance.mesh)];
    const Material& material = scene.materials[std::size_t(instance.material)];
    if (mesh.topology == Topology::kTriangles && material.texture(TextureUse::kNormal))
      FURNACE_CHECK(!mesh.tangents.empty(), "a normal map without tangents on mesh {}", instance.mesh);
  }
  if (scene.instances.empty()) return;
  const Bounds bounds = world_bounds(scene);
  for (int i = 0; i < 3; ++i)
    FURNACE_CHECK(
        std::isfinite(bounds.min[i]) && bounds.min[i] <= bounds.max[i] && std::isfinite(bounds.max[i]),
        "bounds {} to {}", bounds.min[i], bounds.max[i]);
}

}  // namespace furnace::fuzz
