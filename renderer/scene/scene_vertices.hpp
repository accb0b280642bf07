// All that a camera may have to see of a scene.
#pragma once

#include <cmath>

#include <glm/glm.hpp>

#include "renderer/base/error.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Calls visit(p) for every vertex, in the frame whose axes are the columns of `axes`; an empty scene is the
// unit cube.
template <class Visit>
void for_each_vertex(const Scene& scene, const glm::dmat3& axes, Visit&& visit) {
  const glm::dmat3 axes_from_world = glm::transpose(axes);
  bool empty = true;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = *scene.meshes[std::size_t(instance.mesh)];
    if (mesh.indices.empty()) continue;
    const glm::dmat4 world_from_model(instance.world_from_model);
    const glm::dmat3 linear = axes_from_world * glm::dmat3(world_from_model);
    const glm::dvec3 origin = axes_from_world * glm::dvec3(world_from_model[3]);
    for (const glm::vec3& position : mesh.positions) visit(linear * glm::dvec3(position) + origin);
    empty = empty && mesh.positions.empty();
  }
  if (!empty) return;
  for (int corner = 0; corner < 8; ++corner)
    visit(axes_from_world * (glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - 0.5));
}

// `sum`: of zero times each coordinate; not a number when one of them is not finite.
// Errors: kUnprocessable.
inline void check_finite_places(double sum) {
  if (std::isnan(sum))
    fail(ErrorCode::kUnprocessable, "a vertex of the scene has no finite place: no camera can frame it",
         "/camera");
}

}  // namespace furnace
