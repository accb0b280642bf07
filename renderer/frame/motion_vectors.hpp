// How far what a pixel sees has moved in the picture.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/residency/prepared_scene.hpp"
#include "renderer/scene/framing.hpp"

namespace furnace {

// What was there an interval ago, and how it was seen.
struct EarlierScene {
  const Scene& scene;
  View view;
};

// Threads: one, or several that only ask. Owns: which part of the earlier scene each draw is. On the CPU, since a pixel's surface
// and place say all: no shader needs to know another time.
class MotionVectors {
 public:
  // `now` and `earlier` outlive it.
  MotionVectors(Extent picture, const View& view, const PreparedScene& now, const EarlierScene& earlier);

  // Of the point `place` (m, world) of a triangle of the draw `key` (DrawBlock::key): where it is less where it was, px to the
  // right and downwards. What was not there is taken to have stood still; what was behind the camera has not moved.
  glm::vec2 at(std::uint32_t key, std::uint32_t triangle, const glm::vec3& place) const;

 private:
  struct Part {
    const Mesh* now = nullptr;
    const Mesh* earlier = nullptr;  // null: as it is now
    glm::dmat4 world_from_now{1}, world_from_earlier{1};
  };
  glm::dvec3 displacement(const Part& part, std::uint32_t triangle, const glm::dvec3& place) const;

  glm::dvec2 half_px_;
  glm::dmat4 clip_from_world_, earlier_clip_from_world_;
  std::vector<Part> parts_;  // by key less 1
};

}  // namespace furnace
