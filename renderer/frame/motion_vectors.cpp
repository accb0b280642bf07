#include "renderer/frame/motion_vectors.hpp"

#include <array>

namespace furnace {
namespace {

using Corners = std::array<glm::dvec3, 3>;

// Their triangles stand in the file's order, whatever was made of their vertices.
bool correspond(const Mesh& a, const Mesh& b) {
  return a.topology == Topology::kTriangles && b.topology == Topology::kTriangles &&
         a.indices.size() == b.indices.size();
}

Corners corners_of(const Mesh& mesh, const glm::dmat4& world_from_mesh, std::uint32_t triangle) {
  Corners corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::vec3& position = mesh.positions[mesh.indices[3 * std::size_t(triangle) + i]];
    corners[i] = glm::dvec3(world_from_mesh * glm::dvec4(position, 1));
  }
  return corners;
}

// Ericson 2005, "Real-Time Collision Detection", 3.4: shares of the corners in a point of their plane.
glm::dvec3 barycentric(const Corners& corners, const glm::dvec3& place) {
  const glm::dvec3 a = corners[1] - corners[0], b = corners[2] - corners[0], p = place - corners[0];
  const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
  const double pa = glm::dot(p, a), pb = glm::dot(p, b), area2 = aa * bb - ab * ab;
  if (!(area2 > 0)) return glm::dvec3(1.0 / 3);
  const double v = (bb * pa - ab * pb) / area2, w = (aa * pb - ab * pa) / area2;
  return {1 - v - w, v, w};
}

}  // namespace

MotionVectors::MotionVectors(Extent picture, const View& view, const PreparedScene& now,
                             const EarlierScene& earlier)
    : half_px_(picture.width / 2.0, -picture.height / 2.0),
      clip_from_world_(glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world)),
      earlier_clip_from_world_(glm::dmat4(earlier.view.clip_from_view) *
                               glm::dmat4(earlier.view.view_from_world)) {
  std::unordered_map<std::int64_t, const Instance*> earlier_at;
  for (const Instance& instance : earlier.scene.instances) earlier_at.emplace(instance.place, &instance);
  for (const Instance& instance : now.instances) {
    Part part;
    part.now = now.meshes[std::size_t(instance.mesh)].mesh.get();
    part.world_from_now = glm::dmat4(instance.world_from_model);
    if (const auto was = earlier_at.find(instance.place); was != earlier_at.end()) {
      const Mesh& mesh = *earlier.scene.meshes[std::size_t(was->second->mesh)];
      if (correspond(*part.now, mesh)) {
        part.earlier = &mesh;
        part.world_from_earlier = glm::dmat4(was->second->world_from_model);
      }
    }
    parts_.push_back(part);
  }
}

// Of the corners, weighted: what is known of the place itself counts little so, and what stands still has none at all.
glm::dvec3 MotionVectors::displacement(const Part& part, std::uint32_t triangle,
                                       const glm::dvec3& place) const {
  if (part.earlier == nullptr) return glm::dvec3(0);
  const Corners now = corners_of(*part.now, part.world_from_now, triangle);
  const Corners earlier = corners_of(*part.earlier, part.world_from_earlier, triangle);
  const glm::dvec3 share = barycentric(now, place);
  glm::dvec3 moved(0);
  for (int i = 0; i < 3; ++i) moved += share[i] * (now[std::size_t(i)] - earlier[std::size_t(i)]);
  return moved;
}

glm::vec2 MotionVectors::at(std::uint32_t key, std::uint32_t triangle, const glm::vec3& place) const {
  const glm::dvec3 now(place);
  const glm::dvec3 earlier = now - displacement(parts_[key - 1], triangle, now);
  const glm::dvec4 to = clip_from_world_ * glm::dvec4(now, 1);
  const glm::dvec4 from = earlier_clip_from_world_ * glm::dvec4(earlier, 1);
  if (!(to.w > 0) || !(from.w > 0)) return glm::vec2(0);
  return glm::vec2((glm::dvec2(to) / to.w - glm::dvec2(from) / from.w) * half_px_);
}

}  // namespace furnace
