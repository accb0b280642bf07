#include "renderer/scene/tangents.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "renderer/base/check.hpp"

namespace furnace {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

using Corners = std::array<std::uint32_t, 3>;

// Lengths below this count as zero, as in single-precision MikkTSpace.
bool is_positive(double length) {
  return length > std::numeric_limits<float>::min();
}

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return is_positive(length) ? v / length : glm::dvec3(0);
}

glm::dvec3 projected(const glm::dvec3& v, const glm::dvec3& normal) {
  return unit_or_zero(v - normal * glm::dot(normal, v));
}

glm::dvec3 any_perpendicular(const glm::dvec3& normal) {
  const glm::dvec3 axis = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 result = projected(axis, normal);
  return result == glm::dvec3(0) ? glm::dvec3(1, 0, 0) : result;
}

struct Triangle {
  Corners corner{};                        // welded vertices
  Corners neighbour{kNone, kNone, kNone};  // across the edge from corner i to corner i + 1
  Corners group{kNone, kNone, kNone};      // of corner i
  glm::vec3 along_u{0};                    // unit direction of growing u
  bool preserving = false;  // (u, 1 - v) turns as the triangle does: glTF's v points down, the bitangent up
  bool undecided = true;    // no direction of its own: joins whichever group comes first
  bool degenerate = false;  // has two corners in one place
};

struct Group {
  bool preserving = false;
  glm::dvec3 sum{0};  // of angle-weighted directions
  double angle = 0;
  std::optional<glm::vec3> tangent;  // none: the directions cancel
};

// One id per distinct (position, normal, uv).
class Welder {
 public:
  Welder(const Mesh& mesh, const std::vector<glm::vec2>& uvs) : mesh_(mesh), uvs_(uvs) {
    std::size_t capacity = 16;
    while (capacity < mesh.positions.size() * 2) capacity *= 2;
    slots_.assign(capacity, kNone);
  }

  std::uint32_t representative(std::uint32_t vertex) {
    for (std::size_t slot = hash(vertex) & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
      if (slots_[slot] == kNone) slots_[slot] = vertex;
      if (equal(slots_[slot], vertex)) return slots_[slot];
    }
  }

 private:
  bool equal(std::uint32_t a, std::uint32_t b) const {
    return mesh_.positions[a] == mesh_.positions[b] && mesh_.normals[a] == mesh_.normals[b] &&
           uvs_[a] == uvs_[b];
  }

  std::uint64_t hash(std::uint32_t vertex) const {
    const glm::vec3& p = mesh_.positions[vertex];
    const glm::vec3& n = mesh_.normals[vertex];
    const glm::vec2& t = uvs_[vertex];
    std::uint64_t state = 0;
    for (const float value : {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y}) {
      const float canonical = value + 0.0f;  // -0 and 0 are equal
      std::uint32_t bits;
      std::memcpy(&bits, &canonical, sizeof bits);
      state = (state ^ bits) * 0x9E3779B97F4A7C15ull;  // 2^64 / golden ratio: Knuth's multiplicative hashing
      state ^= state >> 32;
    }
    return state;
  }

  const Mesh& mesh_;
  const std::vector<glm::vec2>& uvs_;
  std::vector<std::uint32_t> slots_;
};

// Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", with the conventions of the published
// MikkTSpace: frames belong to corners; corners with one welded vertex, joined by edges and of one UV
// orientation, share a frame: the mean of their triangles' directions, projected to the tangent plane and
// weighted by the corner's angle.
// Threads: one. Owns: its working arrays.
class TangentSpace {
 public:
  TangentSpace(const Mesh& mesh, const std::vector<glm::vec2>& uvs) : mesh_(mesh), uvs_(uvs) {
    weld();
    find_directions();
    find_neighbours();
    form_groups();
    sum_groups();
    finish_groups();
    share_with_stranded_corners();
  }

  // xyz and sign at corner i of triangle t.
  glm::vec4 at(std::uint32_t t, std::uint32_t i) const;

 private:
  struct Edge {
    std::uint32_t high, triangle, index;
    bool upwards;  // from the lower vertex number to the higher
  };

  std::uint32_t vertex(std::uint32_t t, std::uint32_t i) const { return mesh_.indices[3 * t + i]; }
  glm::dvec3 position(std::uint32_t t, std::uint32_t i) const { return mesh_.positions[vertex(t, i)]; }
  glm::dvec3 normal(std::uint32_t t, std::uint32_t i) const { return mesh_.normals[vertex(t, i)]; }

  void weld();
  void find_directions();
  void find_neighbours();
  void match_edges(std::span<Edge> edges);
  void form_groups();
  void spread_group(std::uint32_t group, std::uint32_t welded, std::uint32_t first);
  void sum_groups();
  void finish_groups();
  void share_with_stranded_corners();

  const Mesh& mesh_;
  const std::vector<glm::vec2>& uvs_;
  std::vector<Triangle> triangles_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> group_at_;  // a group at a welded vertex, for corners that are in none
  std::vector<std::uint32_t> open_;      // triangles that a group is about to reach
};

void TangentSpace::weld() {
  Welder welder(mesh_, uvs_);
  std::vector<std::uint32_t> representative(mesh_.positions.size(), kNone);
  triangles_.resize(mesh_.indices.size() / 3);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    Triangle& triangle = triangles_[t];
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::uint32_t& known = representative[vertex(t, i)];
      if (known == kNone) known = welder.representative(vertex(t, i));
      triangle.corner[i] = known;
    }
    const glm::dvec3 a = position(t, 0), b = position(t, 1), c = position(t, 2);
    triangle.degenerate = a == b || b == c || c == a;
  }
}

// The derivative of position by u, up to a positive factor.
void TangentSpace::find_directions() {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    Triangle& triangle = triangles_[t];
    const glm::dvec2 a(uvs_[vertex(t, 0)]);
    const glm::dvec2 ab = glm::dvec2(uvs_[vertex(t, 1)]) - a;
    const glm::dvec2 ac = glm::dvec2(uvs_[vertex(t, 2)]) - a;
    const double twice_area = ab.y * ac.x - ab.x * ac.y;  // in (u, 1 - v)
    const glm::dvec3 d1 = position(t, 1) - position(t, 0);
    const glm::dvec3 d2 = position(t, 2) - position(t, 0);
    const glm::dvec3 by_u = d2 * ab.y - d1 * ac.y;
    const glm::dvec3 by_v = d2 * ab.x - d1 * ac.x;
    triangle.preserving = twice_area > 0;
    if (!is_positive(std::abs(twice_area))) continue;
    triangle.along_u = glm::vec3(unit_or_zero(by_u) * (triangle.preserving ? 1.0 : -1.0));
    triangle.undecided = !is_positive(glm::length(by_u)) || !is_positive(glm::length(by_v));
  }
}

// Pairs the edges that two triangles share in opposite directions; of several on one edge, the first with the
// first.
void TangentSpace::find_neighbours() {
  std::vector<std::uint32_t> begin(mesh_.positions.size() + 1, 0);  // edges by their lower vertex
  const auto for_each_edge = [&](auto&& visit) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t].degenerate) continue;
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t from = triangles_[t].corner[i];
        const std::uint32_t to = triangles_[t].corner[(i + 1) % 3];
        visit(std::min(from, to), Edge{std::max(from, to), t, i, from < to});
      }
    }
  };
  for_each_edge([&](std::uint32_t low, const Edge&) { ++begin[low + 1]; });
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<Edge> edges(begin.back());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for_each_edge([&](std::uint32_t low, const Edge& edge) { edges[next[low]++] = edge; });

  for (std::size_t low = 0; low + 1 < begin.size(); ++low) {
    const auto first = edges.begin() + begin[low], last = edges.begin() + begin[low + 1];
    std::sort(first, last, [](const Edge& a, const Edge& b) {
      return std::tie(a.high, a.triangle, a.index) < std::tie(b.high, b.triangle, b.index);
    });
    for (auto run = first; run != last;) {
      const auto end = std::find_if(run, last, [&](const Edge& edge) { return edge.high != run->high; });
      match_edges({run, end});
      run = end;
    }
  }
}

void TangentSpace::match_edges(std::span<Edge> edges) {
  // Those before `head` are matched or taken; what waits from there on runs all in one direction.
  std::size_t head = 0, tail = 0;
  for (const Edge edge : edges) {
    if (head < tail && edges[head].upwards != edge.upwards) {
      const Edge& partner = edges[head++];
      triangles_[edge.triangle].neighbour[edge.index] = partner.triangle;
      triangles_[partner.triangle].neighbour[partner.index] = edge.triangle;
    } else {
      edges[tail++] = edge;
    }
  }
}

void TangentSpace::form_groups() {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& triangle = triangles_[t];
    if (triangle.degenerate || triangle.undecided) continue;
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (triangle.group[i] != kNone) continue;
      groups_.emplace_back().preserving = triangle.preserving;
      spread_group(static_cast<std::uint32_t>(groups_.size() - 1), triangle.corner[i], t);
    }
  }
}

// Walks from triangle to triangle around one vertex, depth first, the neighbour after the corner before the
// one ahead of it.
void TangentSpace::spread_group(std::uint32_t group, std::uint32_t welded, std::uint32_t first) {
  open_.assign(1, first);
  while (!open_.empty()) {
    const std::uint32_t t = open_.back();
    open_.pop_back();
    if (t == kNone) continue;
    Triangle& triangle = triangles_[t];
    const auto i = static_cast<std::size_t>(
        std::find(triangle.corner.begin(), triangle.corner.end(), welded) - triangle.corner.begin());
    if (triangle.group[i] != kNone) continue;
    if (triangle.undecided && triangle.group == Corners{kNone, kNone, kNone}) {
      triangle.preserving = groups_[group].preserving;
    }
    if (triangle.preserving != groups_[group].preserving) continue;
    triangle.group[i] = group;
    open_.push_back(triangle.neighbour[(i + 2) % 3]);
    open_.push_back(triangle.neighbour[i]);
  }
}

void TangentSpace::sum_groups() {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& triangle = triangles_[t];
    if (triangle.degenerate || triangle.undecided) continue;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const glm::dvec3 n = normal(t, i);
      const glm::dvec3 to_next = projected(position(t, (i + 1) % 3) - position(t, i), n);
      const glm::dvec3 to_last = projected(position(t, (i + 2) % 3) - position(t, i), n);
      const double angle = std::acos(std::clamp(glm::dot(to_next, to_last), -1.0, 1.0));
      Group& group = groups_[triangle.group[i]];
      group.sum += angle * projected(triangle.along_u, n);
      group.angle += angle;
    }
  }
}

void TangentSpace::finish_groups() {
  // Where directions cancel (the pole of a sphere) their sum is noise; each corner keeps its own triangle's.
  constexpr double kCancelled = 1e-4;
  for (Group& group : groups_) {
    const double length = glm::length(group.sum);
    if (length > kCancelled * group.angle) group.tangent = glm::vec3(group.sum / length);
  }
}

void TangentSpace::share_with_stranded_corners() {
  group_at_.assign(mesh_.positions.size(), kNone);
  for (const Triangle& triangle : triangles_) {
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& known = group_at_[triangle.corner[i]];
      if (known == kNone) known = triangle.group[i];
    }
  }
}

glm::vec4 TangentSpace::at(std::uint32_t t, std::uint32_t i) const {
  const Triangle& triangle = triangles_[t];
  const std::uint32_t group = triangle.group[i] != kNone ? triangle.group[i] : group_at_[triangle.corner[i]];
  if (group == kNone) return glm::vec4(glm::vec3(any_perpendicular(normal(t, i))), 1);
  const float sign = groups_[group].preserving ? 1.0f : -1.0f;
  if (groups_[group].tangent) return glm::vec4(*groups_[group].tangent, sign);
  const glm::dvec3 own = projected(triangle.along_u, normal(t, i));
  return glm::vec4(glm::vec3(own == glm::dvec3(0) ? any_perpendicular(normal(t, i)) : own), sign);
}

template <class V>
void gather(std::vector<V>& values, const std::vector<std::uint32_t>& source_vertex) {
  if (values.empty()) return;
  std::vector<V> result;
  result.reserve(source_vertex.size());
  for (const std::uint32_t source : source_vertex) result.push_back(values[source]);
  values = std::move(result);
}

void gather_vertices(Mesh& mesh, const std::vector<std::uint32_t>& source_vertex) {
  gather(mesh.positions, source_vertex);
  gather(mesh.normals, source_vertex);
  for (auto& uvs : mesh.uvs) gather(uvs, source_vertex);
  gather(mesh.colors, source_vertex);
}

// Joins the corners of one old vertex that have the same tangent.
class CornerJoiner {
 public:
  explicit CornerJoiner(std::size_t old_vertices) : newest_(old_vertices, kNone) {}

  std::uint32_t join(std::uint32_t old_vertex, const glm::vec4& tangent) {
    // A vertex with more frames than this is a fan's hub; searching on would make the work quadratic.
    int left = 64;
    for (std::uint32_t v = newest_[old_vertex]; v != kNone && left > 0; v = previous_[v], --left) {
      if (tangents[v] == tangent) return v;
    }
    const auto added = static_cast<std::uint32_t>(tangents.size());
    tangents.push_back(tangent);
    source_vertex.push_back(old_vertex);
    previous_.push_back(std::exchange(newest_[old_vertex], added));
    return added;
  }

  std::vector<glm::vec4> tangents;
  std::vector<std::uint32_t> source_vertex;

 private:
  std::vector<std::uint32_t> newest_, previous_;  // chains of new vertices by old one
};

}  // namespace

std::vector<std::uint32_t> generate_tangents(Mesh& mesh, int uv_set) {
  const std::vector<glm::vec2>& uvs = mesh.uvs.at(static_cast<std::size_t>(uv_set));
  FURNACE_CHECK(mesh.topology == Topology::kTriangles && mesh.indices.size() % 3 == 0, "{} indices",
                mesh.indices.size());
  FURNACE_CHECK(mesh.normals.size() == mesh.positions.size() && uvs.size() == mesh.positions.size(),
                "{} positions, {} normals, {} uvs", mesh.positions.size(), mesh.normals.size(), uvs.size());
  const TangentSpace space(mesh, uvs);
  CornerJoiner joiner(mesh.positions.size());
  std::vector<std::uint32_t> indices;
  indices.reserve(mesh.indices.size());
  for (std::uint32_t corner = 0; corner < mesh.indices.size(); ++corner) {
    indices.push_back(joiner.join(mesh.indices[corner], space.at(corner / 3, corner % 3)));
  }
  gather_vertices(mesh, joiner.source_vertex);
  mesh.tangents = std::move(joiner.tangents);
  mesh.indices = std::move(indices);
  return std::move(joiner.source_vertex);
}

std::vector<std::uint32_t> generate_flat_normals(Mesh& mesh) {
  FURNACE_CHECK(mesh.topology == Topology::kTriangles && mesh.indices.size() % 3 == 0, "{} indices",
                mesh.indices.size());
  mesh.normals.clear();
  mesh.tangents.clear();
  std::vector<std::uint32_t> source_vertex = mesh.indices;
  gather_vertices(mesh, source_vertex);
  mesh.normals.reserve(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    const glm::dvec3 a(mesh.positions[i]), b(mesh.positions[i + 1]), c(mesh.positions[i + 2]);
    const glm::dvec3 normal = unit_or_zero(glm::cross(b - a, c - a));
    mesh.normals.insert(mesh.normals.end(), 3,
                        normal == glm::dvec3(0) ? glm::vec3(0, 1, 0) : glm::vec3(normal));
  }
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) mesh.indices[i] = static_cast<std::uint32_t>(i);
  return source_vertex;
}

}  // namespace furnace
