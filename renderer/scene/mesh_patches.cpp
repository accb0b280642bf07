#include "renderer/scene/mesh_patches.hpp"

#include <limits>
#include <numeric>

namespace furnace {
namespace {

// Tarjan 1975, "Efficiency of a Good But Not Linear Set Union Algorithm"; paths are halved on the way.
std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t vertex) {
  while (parent[vertex] != vertex) {
    parent[vertex] = parent[parent[vertex]];
    vertex = parent[vertex];
  }
  return vertex;
}

}  // namespace

std::vector<std::uint32_t> mesh_patches(const Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::uint32_t root = root_of(parent, mesh.indices[i]);
    parent[root_of(parent, mesh.indices[i + 1])] = root;
    parent[root_of(parent, mesh.indices[i + 2])] = root;
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(parent.size(), kNone), patches(parent.size());
  std::uint32_t count = 0;
  for (std::uint32_t vertex = 0; vertex < parent.size(); ++vertex) {
    std::uint32_t& patch = number[root_of(parent, vertex)];
    if (patch == kNone) patch = count++;
    patches[vertex] = patch;
  }
  return patches;
}

}  // namespace furnace
