// Polygons as triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace furnace {

// A polygon that its first corner sees whole becomes a fan; of another ears are cut off, as seen along its normal, which is
// right for every simple polygon that is about flat, and something of the same outline for the others.
// Errors: kTooLarge for ears of a polygon of more than 4096 sides, or too much work for them in all: it grows with the
// square of the sides. Threads: one. Owns: what it works with.
class PolygonCutter {
 public:
  // Looks at that many corners in all, by default for about a second.
  explicit PolygonCutter(std::int64_t most_work = 500'000'000) : most_work_(most_work) {}

  // Appends the numbers of corners, three a triangle, size - 2 triangles, in the polygon's sense of turning.
  void cut(std::span<const glm::vec3> corners, std::vector<std::uint32_t>& triangles);

 private:
  void cut_ears(std::vector<std::uint32_t>& triangles);
  bool is_ear(std::uint32_t corner);

  std::vector<glm::dvec2> flat_;
  std::vector<std::uint32_t> before_, after_;
  std::vector<char> known_;  // not to be an ear
  std::int64_t most_work_ = 0, work_ = 0;
};

}  // namespace furnace
