#include "renderer/residency/packed_mesh.hpp"

#include <bit>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/mesh_patches.hpp"

namespace furnace {
namespace {

template <class T>
T value_at(const std::vector<T>& values, std::size_t i) {
  return values.empty() ? T(0) : values[i];
}

}  // namespace

PackedMesh pack_mesh(const Mesh& mesh) {
  constexpr std::size_t kMostTriangles = 1u << 24;  // shaders/lib/visibility.glsl
  if (mesh.topology == Topology::kTriangles && mesh.indices.size() / 3 > kMostTriangles) {
    fail(ErrorCode::kTooLarge, fmt::format("mesh \"{}\" has {} triangles, more than {}; divide it", mesh.name,
                                           mesh.indices.size() / 3, kMostTriangles));
  }
  PackedMesh packed;
  packed.rows_per_vertex = mesh.colors.empty() ? 4 : 5;
  packed.rows.reserve(mesh.positions.size() * packed.rows_per_vertex);
  const std::vector<std::uint32_t> patches = mesh_patches(mesh);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    packed.rows.emplace_back(mesh.positions[i], std::bit_cast<float>(patches[i]));
    packed.rows.emplace_back(value_at(mesh.normals, i), 0);
    packed.rows.push_back(value_at(mesh.tangents, i));
    packed.rows.emplace_back(value_at(mesh.uvs[0], i), value_at(mesh.uvs[1], i));
    if (!mesh.colors.empty()) packed.rows.push_back(mesh.colors[i]);
  }
  return packed;
}

}  // namespace furnace
