#include "renderer/scene/model_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace furnace {
namespace {

// All attributes of one vertex; without padding, so that bytes compare.
struct Vertex {
  glm::vec3 position{0}, normal{0};
  glm::vec2 uv{0};
  glm::vec4 color{0};
};
static_assert(sizeof(Vertex) == 12 * sizeof(float));

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
// Where more corners meet, as in the pole of a fan, all share one normal: the work stays linear.
constexpr std::size_t kMostMet = 256;

struct Entry {
  std::uint64_t hash;
  std::uint32_t index;
};

// By the upper bits of the hash first: what is left to sort then fits a processor's cache.
template <class Less>
void sort_by_hash(std::vector<Entry>& entries, const Less& less) {
  constexpr int kBits = 12;
  const auto bucket_of = [](const Entry& entry) { return std::size_t(entry.hash >> (64 - kBits)); };
  std::vector<std::size_t> begin((std::size_t{1} << kBits) + 1, 0);
  for (const Entry& entry : entries) ++begin[bucket_of(entry) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Entry> sorted(entries.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (const Entry& entry : entries) sorted[next[bucket_of(entry)]++] = entry;
  for (std::size_t i = 0; i + 1 < begin.size(); ++i)
    std::sort(sorted.begin() + std::ptrdiff_t(begin[i]), sorted.begin() + std::ptrdiff_t(begin[i + 1]), less);
  entries = std::move(sorted);
}

// For each value the first of the same bytes. Sorted, not hashed into buckets: a file that was made for collisions costs no
// more than others.
template <class Value>
std::vector<std::uint32_t> firsts_of(const std::vector<Value>& values) {
  std::vector<Entry> order(values.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    const std::string_view bytes(reinterpret_cast<const char*>(&values[i]), sizeof(Value));
    order[i] = {std::hash<std::string_view>{}(bytes), i};
  }
  const auto compare = [&](const Entry& a, const Entry& b) {
    return std::memcmp(&values[a.index], &values[b.index], sizeof(Value));
  };
  sort_by_hash(order, [&](const Entry& a, const Entry& b) {
    if (a.hash != b.hash) return a.hash < b.hash;
    const int difference = compare(a, b);
    return difference != 0 ? difference < 0 : a.index < b.index;
  });
  std::vector<std::uint32_t> first(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && order[i].hash == order[i - 1].hash && compare(order[i], order[i - 1]) == 0;
    first[order[i].index] = same ? first[order[i - 1].index] : order[i].index;
  }
  return first;
}

// -0 is 0.
glm::vec3 without_sign_of_zero(const glm::vec3& v) {
  return v + 0.0f;
}

std::vector<Vertex> vertices_of(const Mesh& mesh) {
  std::vector<Vertex> vertices(mesh.positions.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    Vertex& vertex = vertices[i];
    vertex.position = without_sign_of_zero(mesh.positions[i]);
    if (!mesh.normals.empty()) vertex.normal = without_sign_of_zero(mesh.normals[i]);
    if (!mesh.uvs[0].empty()) vertex.uv = mesh.uvs[0][i];
    if (!mesh.colors.empty()) vertex.color = mesh.colors[i];
  }
  return vertices;
}

// Vertices in the order in which corners first ask for them. Threads: one. Owns: what it has gathered.
class Gathered {
 public:
  explicit Gathered(const Mesh& like)
      : has_normals_(!like.normals.empty()),
        has_uvs_(!like.uvs[0].empty()),
        has_colors_(!like.colors.empty()) {}

  std::uint32_t add(const Vertex& vertex) {
    positions_.push_back(vertex.position);
    if (has_normals_) normals_.push_back(vertex.normal);
    if (has_uvs_) uvs_.push_back(vertex.uv);
    if (has_colors_) colors_.push_back(vertex.color);
    return std::uint32_t(positions_.size() - 1);
  }
  const glm::vec3& normal(std::uint32_t vertex) const { return normals_[vertex]; }
  void give(Mesh& mesh) {
    mesh.positions = std::move(positions_);
    mesh.normals = std::move(normals_);
    mesh.uvs[0] = std::move(uvs_);
    mesh.colors = std::move(colors_);
  }

 private:
  bool has_normals_, has_uvs_, has_colors_;
  std::vector<glm::vec3> positions_, normals_;
  std::vector<glm::vec2> uvs_;
  std::vector<glm::vec4> colors_;
};

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : glm::dvec3(0);
}

struct Facings {
  std::vector<glm::dvec3> normals;  // of triangles
  std::vector<double> angles;       // of corners

  glm::dvec3 weighted(std::uint32_t corner) const { return normals[corner / 3] * angles[corner]; }
};

Facings facings_of(const Mesh& mesh, std::span<const Vertex> vertices) {
  Facings facings;
  facings.normals.resize(mesh.indices.size() / 3);
  facings.angles.resize(mesh.indices.size());
  for (std::size_t t = 0; t < facings.normals.size(); ++t) {
    glm::dvec3 p[3];
    for (std::size_t k = 0; k < 3; ++k) p[k] = vertices[mesh.indices[3 * t + k]].position;
    facings.normals[t] = unit_or_zero(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 a = unit_or_zero(p[(k + 1) % 3] - p[k]), b = unit_or_zero(p[(k + 2) % 3] - p[k]);
      facings.angles[3 * t + k] = std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
    }
  }
  return facings;
}

// Corners of the same position, behind one another; where a group begins.
struct Meetings {
  std::vector<std::uint32_t> corners, begin;
};

Meetings meetings_of(const Mesh& mesh, std::span<const Vertex> vertices) {
  std::vector<glm::vec3> positions(vertices.size());
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = vertices[i].position;
  const std::vector<std::uint32_t> place = firsts_of(positions);
  Meetings out;
  out.begin.resize(vertices.size() + 1);
  for (const std::uint32_t vertex : mesh.indices) ++out.begin[place[vertex] + std::size_t{1}];
  std::partial_sum(out.begin.begin(), out.begin.end(), out.begin.begin());
  out.corners.resize(mesh.indices.size());
  std::vector<std::uint32_t> next(out.begin.begin(), out.begin.end() - 1);
  for (std::uint32_t i = 0; i < mesh.indices.size(); ++i) out.corners[next[place[mesh.indices[i]]]++] = i;
  return out;
}

std::vector<glm::vec3> corner_normals(const Mesh& mesh, std::span<const Vertex> vertices) {
  constexpr double kCosSharp = 0.70710678118654752;  // 45 degrees
  const Facings facings = facings_of(mesh, vertices);
  const Meetings meetings = meetings_of(mesh, vertices);
  std::vector<glm::vec3> normals(mesh.indices.size());
  for (std::size_t group = 0; group + 1 < meetings.begin.size(); ++group) {
    const std::span<const std::uint32_t> met(meetings.corners.data() + meetings.begin[group],
                                             meetings.corners.data() + meetings.begin[group + 1]);
    glm::dvec3 all(0);
    for (const std::uint32_t other : met) all += facings.weighted(other);
    for (const std::uint32_t corner : met) {
      glm::dvec3 sum(0);
      if (met.size() <= kMostMet) {
        for (const std::uint32_t other : met)
          if (glm::dot(facings.normals[corner / 3], facings.normals[other / 3]) > kCosSharp)
            sum += facings.weighted(other);
      }
      // A triangle without area has no say, and takes what its neighbours have.
      if (sum == glm::dvec3(0)) sum = all;
      const glm::dvec3 normal = unit_or_zero(sum);
      normals[corner] = normal == glm::dvec3(0) ? glm::vec3(0, 1, 0) : glm::vec3(normal);
    }
  }
  return normals;
}

}  // namespace

void weld_vertices(Mesh& mesh) {
  const std::vector<Vertex> vertices = vertices_of(mesh);
  const std::vector<std::uint32_t> first = firsts_of(vertices);
  std::vector<std::uint32_t> made(vertices.size(), kNone);  // of the first of its kind
  Gathered gathered(mesh);
  for (std::uint32_t& index : mesh.indices) {
    std::uint32_t& vertex = made[first[index]];
    if (vertex == kNone) vertex = gathered.add(vertices[index]);
    index = vertex;
  }
  gathered.give(mesh);
}

void generate_smooth_normals(Mesh& mesh) {
  mesh.normals.clear();
  std::vector<Vertex> vertices = vertices_of(mesh);
  const std::vector<glm::vec3> normals = corner_normals(mesh, vertices);
  const std::vector<std::uint32_t> first = firsts_of(vertices);
  // What was made of each vertex, one for each normal: a chain of kMostMet at most.
  std::vector<std::uint32_t> made(vertices.size(), kNone), next;
  mesh.normals.assign(1, glm::vec3(0));
  Gathered gathered(mesh);
  for (std::size_t corner = 0; corner < normals.size(); ++corner) {
    std::uint32_t& index = mesh.indices[corner];
    Vertex vertex = vertices[index];
    vertex.normal = normals[corner];
    std::uint32_t& begin = made[first[index]];
    std::uint32_t known = begin;
    const auto differs = [&](std::uint32_t other) {
      return std::memcmp(&gathered.normal(other), &vertex.normal, sizeof vertex.normal) != 0;
    };
    while (known != kNone && differs(known)) known = next[known];
    if (known == kNone) {
      known = gathered.add(vertex);
      next.push_back(begin);
      begin = known;
    }
    index = known;
  }
  gathered.give(mesh);
}

}  // namespace furnace
