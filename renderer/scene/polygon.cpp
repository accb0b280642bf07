#include "renderer/scene/polygon.hpp"

#include <utility>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

constexpr std::size_t kMostSides = 4096;

// As long as twice the area.
glm::dvec3 normal_of(std::span<const glm::vec3> corners) {
  glm::dvec3 sum(0);
  const glm::dvec3 origin(corners[0]);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += glm::cross(glm::dvec3(corners[i]) - origin, glm::dvec3(corners[i + 1]) - origin);
  return sum;
}

// Along the axis that its normal is nearest to, turning counter-clockwise.
void project(std::span<const glm::vec3> corners, std::vector<glm::dvec2>& out) {
  const glm::dvec3 normal = normal_of(corners), size = glm::abs(normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  out.clear();
  for (const glm::vec3& corner : corners) out.emplace_back(corner[u], corner[v]);
}

// Twice the area; positive where a, b, c turn counter-clockwise.
double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool is_fan(std::span<const glm::dvec2> flat) {
  for (std::size_t i = 1; i + 1 < flat.size(); ++i)
    if (!(turn(flat[0], flat[i], flat[i + 1]) >= 0)) return false;
  return true;
}

}  // namespace

void PolygonCutter::cut(std::span<const glm::vec3> corners, std::vector<std::uint32_t>& triangles) {
  if (corners.size() < 3) return;
  if (corners.size() > 3) project(corners, flat_);
  if (corners.size() == 3 || is_fan(flat_)) {
    for (std::uint32_t i = 1; i + 1 < corners.size(); ++i) triangles.insert(triangles.end(), {0, i, i + 1});
    return;
  }
  if (corners.size() > kMostSides)
    fail(ErrorCode::kTooLarge, "the model has a polygon of more than 4096 sides that is no fan");
  cut_ears(triangles);
}

// A corner whose triangle with its neighbours lies inside: it turns the right way, and no other corner is in there. Those
// at the same place as one of the three do not count: a hole is reached by a side that is walked twice.
bool PolygonCutter::is_ear(std::uint32_t corner) {
  const std::uint32_t first = before_[corner], last = after_[corner];
  const glm::dvec2 &a = flat_[first], &b = flat_[corner], &c = flat_[last];
  if (!(turn(a, b, c) > 0)) return false;
  for (std::uint32_t i = after_[last]; i != first; i = after_[i]) {
    ++work_;
    const glm::dvec2& p = flat_[i];
    if (turn(a, b, p) < 0 || turn(b, c, p) < 0 || turn(c, a, p) < 0) continue;
    if (p != a && p != b && p != c) return false;
  }
  return true;
}

// Cutting an ear off makes ears of its neighbours only (Eberly 2002, "Triangulation by Ear Clipping"), so each other corner
// is looked at once.
void PolygonCutter::cut_ears(std::vector<std::uint32_t>& triangles) {
  const auto sides = std::uint32_t(flat_.size());
  before_.resize(sides);
  after_.resize(sides);
  known_.assign(sides, 0);
  for (std::uint32_t i = 0; i < sides; ++i) {
    before_[i] = i == 0 ? sides - 1 : i - 1;
    after_[i] = i + 1 == sides ? 0 : i + 1;
  }
  std::uint32_t at = 0, left = sides, passed = 0;
  while (left > 3) {
    ++work_;
    const bool ear = known_[at] == 0 && is_ear(at);
    if (work_ > most_work_) fail(ErrorCode::kTooLarge, "the model has too many polygons of too many sides");
    // A polygon that crosses itself may have none: then any will do.
    if (!ear && passed < left) {
      known_[at] = 1;
      ++passed;
      at = after_[at];
      continue;
    }
    const std::uint32_t first = before_[at], last = after_[at];
    triangles.insert(triangles.end(), {first, at, last});
    after_[first] = last;
    before_[last] = first;
    known_[first] = known_[last] = 0;
    passed = 0;
    --left;
    at = last;
  }
  triangles.insert(triangles.end(), {before_[at], at, after_[at]});
}

}  // namespace furnace
