#include "renderer/scene/model_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace furnace {
namespace {

// All attributes of one vertex; without padding, so that bytes compare.
struct Corner {
  glm::vec3 position{0}, normal{0};
  glm::vec2 uv{0};
  glm::vec4 color{0};
};
static_assert(sizeof(Corner) == 12 * sizeof(float));

// For each value the number of its group, groups counted in order of first appearance. Sorted, not hashed into buckets: a
// file that was made for collisions costs no more than others.
template <class Value>
std::vector<std::uint32_t> groups_of(const std::vector<Value>& values, std::uint32_t& groups) {
  struct Entry {
    std::size_t hash;
    std::uint32_t index;
  };
  std::vector<Entry> order(values.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    const std::string_view bytes(reinterpret_cast<const char*>(&values[i]), sizeof(Value));
    order[i] = {std::hash<std::string_view>{}(bytes), i};
  }
  const auto compare = [&](const Entry& a, const Entry& b) {
    return std::memcmp(&values[a.index], &values[b.index], sizeof(Value));
  };
  std::ranges::sort(order, [&](const Entry& a, const Entry& b) {
    if (a.hash != b.hash) return a.hash < b.hash;
    const int difference = compare(a, b);
    return difference != 0 ? difference < 0 : a.index < b.index;
  });
  std::vector<std::uint32_t> first(values.size());  // the first value of the same bytes
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && order[i].hash == order[i - 1].hash && compare(order[i], order[i - 1]) == 0;
    first[order[i].index] = same ? first[order[i - 1].index] : order[i].index;
  }
  groups = 0;
  for (std::uint32_t i = 0; i < first.size(); ++i) first[i] = first[i] == i ? groups++ : first[first[i]];
  return first;
}

// -0 is 0.
glm::vec3 without_sign_of_zero(const glm::vec3& v) {
  return v + 0.0f;
}

std::vector<Corner> corners_of(const Mesh& mesh) {
  std::vector<Corner> corners(mesh.indices.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t vertex = mesh.indices[i];
    Corner& corner = corners[i];
    corner.position = without_sign_of_zero(mesh.positions[vertex]);
    if (!mesh.normals.empty()) corner.normal = without_sign_of_zero(mesh.normals[vertex]);
    if (!mesh.uvs[0].empty()) corner.uv = mesh.uvs[0][vertex];
    if (!mesh.colors.empty()) corner.color = mesh.colors[vertex];
  }
  return corners;
}

// Corners become the mesh's vertices, equal ones once.
void set_corners(Mesh& mesh, const std::vector<Corner>& corners) {
  std::uint32_t count = 0;
  mesh.indices = groups_of(corners, count);
  const auto resize = [&](auto& values) {
    if (!values.empty()) values.resize(count);
  };
  const bool has_normals = !mesh.normals.empty(), has_uvs = !mesh.uvs[0].empty(),
             has_colors = !mesh.colors.empty();
  mesh.positions.resize(count);
  resize(mesh.normals);
  resize(mesh.uvs[0]);
  resize(mesh.colors);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t vertex = mesh.indices[i];
    mesh.positions[vertex] = corners[i].position;
    if (has_normals) mesh.normals[vertex] = corners[i].normal;
    if (has_uvs) mesh.uvs[0][vertex] = corners[i].uv;
    if (has_colors) mesh.colors[vertex] = corners[i].color;
  }
}

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : glm::dvec3(0);
}

// Of one corner: the normal of its triangle, and that times the angle there.
struct Facing {
  glm::dvec3 normal{0}, weighted{0};
};

std::vector<Facing> facings_of(std::span<const Corner> corners) {
  std::vector<Facing> facings(corners.size());
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const glm::dvec3 p[3] = {corners[i].position, corners[i + 1].position, corners[i + 2].position};
    const glm::dvec3 normal = unit_or_zero(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 a = unit_or_zero(p[(k + 1) % 3] - p[k]), b = unit_or_zero(p[(k + 2) % 3] - p[k]);
      facings[i + k] = {normal, normal * std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0))};
    }
  }
  return facings;
}

// Corners of the same position, behind one another; where a group begins.
struct Meetings {
  std::vector<std::uint32_t> corners, begin;
};

Meetings meetings_of(std::span<const Corner> corners) {
  std::vector<glm::vec3> positions(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) positions[i] = corners[i].position;
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> group = groups_of(positions, count);
  Meetings out;
  out.begin.resize(count + std::size_t{1});
  for (const std::uint32_t g : group) ++out.begin[g + std::size_t{1}];
  std::partial_sum(out.begin.begin(), out.begin.end(), out.begin.begin());
  out.corners.resize(corners.size());
  std::vector<std::uint32_t> next(out.begin.begin(), out.begin.end() - 1);
  for (std::uint32_t i = 0; i < group.size(); ++i) out.corners[next[group[i]]++] = i;
  return out;
}

}  // namespace

void weld_vertices(Mesh& mesh) {
  set_corners(mesh, corners_of(mesh));
}

void generate_smooth_normals(Mesh& mesh) {
  constexpr double kCosSharp = 0.70710678118654752;  // 45 degrees
  // Where more meet, as in the pole of a fan, all are one: the work stays linear.
  constexpr std::size_t kMostMet = 256;
  mesh.normals.assign(mesh.positions.size(), glm::vec3(0));
  std::vector<Corner> corners = corners_of(mesh);
  const std::vector<Facing> facings = facings_of(corners);
  const Meetings meetings = meetings_of(corners);
  for (std::size_t group = 0; group + 1 < meetings.begin.size(); ++group) {
    const std::span<const std::uint32_t> met(meetings.corners.data() + meetings.begin[group],
                                             meetings.corners.data() + meetings.begin[group + 1]);
    glm::dvec3 all(0);
    for (const std::uint32_t other : met) all += facings[other].weighted;
    for (const std::uint32_t corner : met) {
      glm::dvec3 sum(0);
      if (met.size() <= kMostMet) {
        for (const std::uint32_t other : met)
          if (glm::dot(facings[corner].normal, facings[other].normal) > kCosSharp)
            sum += facings[other].weighted;
      }
      // A triangle without area has no say, and takes what its neighbours have.
      if (sum == glm::dvec3(0)) sum = all;
      const glm::dvec3 normal = unit_or_zero(sum);
      corners[corner].normal = normal == glm::dvec3(0) ? glm::vec3(0, 1, 0) : glm::vec3(normal);
    }
  }
  set_corners(mesh, corners);
}

}  // namespace furnace
