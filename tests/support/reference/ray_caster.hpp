// Judge of what sees what: triangles in world space, hit by rays in double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace::reference {

struct Hit {
  double distance = 0;                                // along the ray's direction
  glm::dvec3 position{0}, normal{0}, face_normal{0};  // both unit, towards where the ray comes from
  int material = 0;
};

// Threads: a value. Owns: its triangles, in a tree of boxes halved at the median.
class RayCaster {
 public:
  explicit RayCaster(const Scene& scene) {
    for (const Instance& instance : scene.instances) add(*scene.meshes[std::size_t(instance.mesh)], instance);
    order_.resize(triangles_.size());
    std::iota(order_.begin(), order_.end(), 0);
    if (!triangles_.empty()) build(0, int(order_.size()));
  }

  std::optional<Hit> nearest(const glm::dvec3& origin, const glm::dvec3& direction) const {
    Found found;
    visit(0, origin, direction, 1.0 / direction, found, false);
    if (found.triangle < 0) return std::nullopt;
    const Triangle& t = triangles_[std::size_t(found.triangle)];
    Hit hit;
    hit.distance = found.distance;
    hit.position = origin + direction * found.distance;
    hit.normal =
        glm::normalize(t.normal[0] * (1 - found.u - found.v) + t.normal[1] * found.u + t.normal[2] * found.v);
    hit.face_normal = glm::normalize(glm::cross(t.edge[0], t.edge[1]));
    if (glm::dot(hit.face_normal, hit.normal) < 0) hit.face_normal = -hit.face_normal;
    if (glm::dot(hit.face_normal, direction) > 0) {
      hit.face_normal = -hit.face_normal;
      hit.normal = -hit.normal;
    }
    hit.material = t.material;
    return hit;
  }

  bool is_free(const glm::dvec3& origin, const glm::dvec3& direction) const {
    Found found;
    visit(0, origin, direction, 1.0 / direction, found, true);
    return found.triangle < 0;
  }

 private:
  struct Triangle {
    glm::dvec3 corner{0}, edge[2], normal[3];
    glm::dvec3 low{0}, high{0};
    int material = 0;
  };
  struct Node {
    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
    int first = 0, count = 0;  // of order_, in a leaf
    int second = 0;            // child; the first child stands next
  };
  struct Found {
    double distance = std::numeric_limits<double>::infinity(), u = 0, v = 0;
    int triangle = -1;
  };

  void add(const Mesh& mesh, const Instance& instance) {
    const glm::dmat4 world(instance.world_from_model);
    const glm::dmat3 normals = glm::transpose(glm::inverse(glm::dmat3(world)));
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      Triangle t;
      glm::dvec3 at[3];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t vertex = mesh.indices[i + std::size_t(k)];
        at[k] = glm::dvec3(world * glm::dvec4(glm::dvec3(mesh.positions[vertex]), 1));
        t.normal[k] = glm::normalize(normals * glm::dvec3(mesh.normals[vertex]));
      }
      t.corner = at[0];
      t.edge[0] = at[1] - at[0];
      t.edge[1] = at[2] - at[0];
      t.low = glm::min(at[0], glm::min(at[1], at[2]));
      t.high = glm::max(at[0], glm::max(at[1], at[2]));
      t.material = instance.material;
      triangles_.push_back(t);
    }
  }

  int build(int first, int count) {
    const int self = int(nodes_.size());
    nodes_.emplace_back();
    Node node;
    for (int i = first; i < first + count; ++i) {
      const Triangle& t = triangles_[std::size_t(order_[std::size_t(i)])];
      node.low = glm::min(node.low, t.low);
      node.high = glm::max(node.high, t.high);
    }
    constexpr int kLeaf = 4;
    if (count <= kLeaf) {
      node.first = first;
      node.count = count;
    } else {
      const glm::dvec3 size = node.high - node.low;
      const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
      const auto middle = [&](int i) {
        const Triangle& t = triangles_[std::size_t(i)];
        return t.low[axis] + t.high[axis];
      };
      std::nth_element(order_.begin() + first, order_.begin() + first + count / 2,
                       order_.begin() + first + count, [&](int a, int b) { return middle(a) < middle(b); });
      build(first, count / 2);
      node.second = build(first + count / 2, count - count / 2);
    }
    nodes_[std::size_t(self)] = node;
    return self;
  }

  // Kay and Kajiya 1986, "Ray Tracing Complex Scenes": slabs.
  static bool meets(const Node& node, const glm::dvec3& origin, const glm::dvec3& per_direction,
                    double farthest) {
    double near = 0, far = farthest;
    for (int axis = 0; axis < 3; ++axis) {
      double a = (node.low[axis] - origin[axis]) * per_direction[axis],
             b = (node.high[axis] - origin[axis]) * per_direction[axis];
      if (a > b) std::swap(a, b);
      near = std::max(near, a);
      far = std::min(far, b);
    }
    return near <= far * (1 + 1e-12);
  }

  void visit(int index, const glm::dvec3& origin, const glm::dvec3& direction,
             const glm::dvec3& per_direction, Found& found, bool any) const {
    if (nodes_.empty()) return;
    const Node& node = nodes_[std::size_t(index)];
    if (!meets(node, origin, per_direction, found.distance)) return;
    if (node.count > 0) {
      for (int i = node.first; i < node.first + node.count; ++i)
        test(order_[std::size_t(i)], origin, direction, found);
      return;
    }
    visit(index + 1, origin, direction, per_direction, found, any);
    if (any && found.triangle >= 0) return;
    visit(node.second, origin, direction, per_direction, found, any);
  }

  // Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
  void test(int index, const glm::dvec3& origin, const glm::dvec3& direction, Found& found) const {
    const Triangle& t = triangles_[std::size_t(index)];
    const glm::dvec3 p = glm::cross(direction, t.edge[1]);
    const double determinant = glm::dot(t.edge[0], p);
    if (determinant == 0) return;
    const glm::dvec3 from = origin - t.corner;
    const double u = glm::dot(from, p) / determinant;
    if (u < 0 || u > 1) return;
    const glm::dvec3 q = glm::cross(from, t.edge[0]);
    const double v = glm::dot(direction, q) / determinant;
    if (v < 0 || u + v > 1) return;
    const double distance = glm::dot(t.edge[1], q) / determinant;
    if (distance > 0 && distance < found.distance) found = {distance, u, v, index};
  }

  std::vector<Triangle> triangles_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace furnace::reference
