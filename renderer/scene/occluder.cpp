#include "renderer/scene/occluder.hpp"

#include <algorithm>

#include <meshoptimizer.h>

namespace furnace {

std::vector<std::uint32_t> occluder_indices(const Mesh& mesh, const OccluderLimits& limits) {
  constexpr std::size_t kFew = 3 * 500;
  const std::size_t count = mesh.indices.size();
  if (count <= kFew) return mesh.indices;
  const float* positions = &mesh.positions.front().x;
  const std::size_t vertices = mesh.positions.size(), stride = sizeof(glm::vec3);
  // Seams of attributes are none of shadows: equal positions become one vertex.
  std::vector<std::uint32_t> welded(count), simplified(count);
  meshopt_generateShadowIndexBuffer(welded.data(), mesh.indices.data(), count, positions, vertices, stride,
                                    stride);
  float error = 0;
  simplified.resize(meshopt_simplify(simplified.data(), welded.data(), count, positions, vertices, stride,
                                     std::max(kFew, count / limits.share / 3 * 3), float(limits.error), 0,
                                     &error));
  return simplified;
}

}  // namespace furnace
