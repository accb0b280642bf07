#include "renderer/scene/precision.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace furnace {

std::optional<Note> precision_note(const Scene& scene) {
  constexpr double kShows = 1.0 / 2000;  // of the scene's size: half a pixel of a picture of a thousand
  Bounds bounds;
  for (const Instance& instance : scene.instances) {
    const Bounds& box = scene.meshes[std::size_t(instance.mesh)]->bounds;
    if (box.empty()) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec4 point(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                            corner & 4 ? box.max.z : box.min.z, 1);
      bounds.add(glm::vec3(instance.world_from_model * point));
    }
  }
  if (bounds.empty()) return std::nullopt;
  const glm::vec3 farthest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
  const double step =
      double(std::max({farthest.x, farthest.y, farthest.z})) * std::numeric_limits<float>::epsilon();
  const double size = glm::length(glm::dvec3(bounds.max) - glm::dvec3(bounds.min));
  if (!(step > size * kShows) || size == 0) return std::nullopt;
  return Note{
      "far-from-origin", "",
      fmt::format("lies so far from the origin that single precision places its points in steps of {:.2g} "
                  "m, and it is {:.2g} m large; bring it nearer",
                  step, size)};
}

}  // namespace furnace
