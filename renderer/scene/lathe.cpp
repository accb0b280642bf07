#include "renderer/scene/lathe.hpp"

#include "renderer/scene/transform.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace furnace {
namespace {

int arc_steps(double arc_radius, double angle_rad) {
  constexpr double kSagitta = 1e-4;  // m: a tenth of a pixel when 1 m fills 1024
  const double by_sagitta = 2 * std::acos(1 - std::min(1.0, kSagitta / std::abs(arc_radius)));
  const double step = std::min(by_sagitta, radians_from_degrees(10));
  return std::max(1, int(std::ceil(std::abs(angle_rad) / step - 1e-9)));
}

std::vector<double> arc_lengths(const std::vector<ProfilePoint>& points) {
  std::vector<double> lengths{0};
  for (std::size_t i = 1; i < points.size(); ++i)
    lengths.push_back(lengths.back() + std::hypot(points[i].radius - points[i - 1].radius,
                                                  points[i].height - points[i - 1].height));
  return lengths;
}

// One turn in equal steps; the last column lies on the first.
struct Columns {
  std::vector<double> sin_phi, cos_phi;

  explicit Columns(int segments) {
    for (int j = 0; j <= segments; ++j) {
      const double phi = 2 * kPi * ((j % segments) / double(segments) - 0.5);
      sin_phi.push_back(std::sin(phi));
      cos_phi.push_back(std::cos(phi));
    }
  }
};

// A ring of vertices per profile point. On the axis each segment has its own vertex at the middle of its u;
// the last one of the ring serves no segment there.
void add_ring(Mesh& mesh, const ProfilePoint& point, double v, const Columns& columns,
              const Placement& placement) {
  const int segments = int(columns.sin_phi.size()) - 1;
  const double sin_n = std::sin(point.normal_rad), cos_n = std::cos(point.normal_rad);
  for (int j = 0; j <= segments; ++j) {
    const double s = columns.sin_phi[j], c = columns.cos_phi[j];
    const glm::dvec3 position(point.radius * s, point.height, point.radius * c);
    const glm::dvec3 normal(sin_n * s, cos_n, sin_n * c);
    const double u = point.radius > 0 ? j / double(segments) : (std::min(j, segments - 1) + 0.5) / segments;
    mesh.positions.emplace_back(placement.rotation * position + placement.origin);
    mesh.normals.emplace_back(placement.rotation * normal);
    mesh.tangents.emplace_back(placement.rotation * glm::dvec3(c, 0, -s), 1);
    mesh.uvs[0].emplace_back(u, v);
  }
}

// The strip between two rings, wound counter-clockwise seen from outside.
void add_strip(Mesh& mesh, std::uint32_t upper, std::uint32_t lower, int segments, bool upper_pole,
               bool lower_pole) {
  for (int j = 0; j < segments; ++j) {
    const std::uint32_t a = upper + j, b = lower + j;
    if (!lower_pole) mesh.indices.insert(mesh.indices.end(), {a, b, b + 1});
    if (!upper_pole) mesh.indices.insert(mesh.indices.end(), {a, lower_pole ? b : b + 1, a + 1});
  }
}

}  // namespace

Profile& Profile::turn(double arc_radius, double to_normal_rad) {
  const ProfilePoint from = end();
  const double angle = to_normal_rad - from.normal_rad;
  const double centre_radius = from.radius - arc_radius * std::sin(from.normal_rad);
  const double centre_height = from.height - arc_radius * std::cos(from.normal_rad);
  const int steps = arc_steps(arc_radius, angle);
  for (int i = 1; i <= steps; ++i) {
    const double normal_rad = i == steps ? to_normal_rad : from.normal_rad + angle * i / steps;
    points_.push_back({centre_radius + arc_radius * std::sin(normal_rad),
                       centre_height + arc_radius * std::cos(normal_rad), normal_rad});
  }
  // An arc that ends on the axis ends there exactly.
  if (std::abs(end().radius) < 1e-9) points_.back().radius = 0;
  return *this;
}

Profile& Profile::forward(double length) {
  const ProfilePoint from = end();
  points_.push_back({from.radius + length * std::cos(from.normal_rad),
                     from.height - length * std::sin(from.normal_rad), from.normal_rad});
  return *this;
}

Profile& Profile::forward_to_radius(double radius) {
  const double length = (radius - end().radius) / std::cos(end().normal_rad);
  forward(length);
  points_.back().radius = radius;
  return *this;
}

Profile& Profile::edge(double to_normal_rad) {
  points_.push_back({end().radius, end().height, to_normal_rad});
  return *this;
}

Profile& Profile::close() {
  points_.back().radius = points_.front().radius;
  points_.back().height = points_.front().height;
  return *this;
}

Profile& Profile::shift(double height) {
  for (ProfilePoint& point : points_) point.height += height;
  return *this;
}

Mesh lathe(std::string name, const Profile& profile, int segments, const Placement& placement) {
  const std::vector<ProfilePoint>& points = profile.points();
  const std::vector<double> lengths = arc_lengths(points);
  const Columns columns(segments);
  const std::uint32_t ring = segments + 1;
  Mesh mesh;
  mesh.name = std::move(name);
  for (std::size_t i = 0; i < points.size(); ++i) {
    add_ring(mesh, points[i], lengths[i] / lengths.back(), columns, placement);
    if (i == 0 || lengths[i] == lengths[i - 1]) continue;  // an edge has no surface of its own
    add_strip(mesh, ring * (i - 1), ring * i, segments, points[i - 1].radius == 0, points[i].radius == 0);
  }
  for (const glm::vec3& position : mesh.positions) mesh.bounds.add(position);
  return mesh;
}

}  // namespace furnace
