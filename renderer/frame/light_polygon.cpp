#include "renderer/frame/light_polygon.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

// Sutherland and Hodgman 1974, "Reentrant Polygon Clipping", for one edge: what lies on the side of `sign` from `limit` along an axis.
LightPolygon cut(const LightPolygon& polygon, int axis, double limit, double sign) {
  LightPolygon out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double dp = sign * (p[axis] - limit), dq = sign * (q[axis] - limit);
    if (dp >= 0) out.push_back(p);
    if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) out.push_back(p + (q - p) * (dp / (dp - dq)));
  }
  return out;
}

// What lies between the shares `from` and `to` of the area, counted along an axis.
LightPolygon slice(const LightPolygon& polygon, int axis, double from, double to) {
  const double whole = area(polygon);
  const auto ends = std::minmax_element(polygon.begin(), polygon.end(),
                                        [&](auto& a, auto& b) { return a[axis] < b[axis]; });
  const auto place = [&](double share) {
    double low = (*ends.first)[axis], high = (*ends.second)[axis];
    for (int step = 0; step < 50; ++step) {
      const double middle = (low + high) / 2;
      (area(cut(polygon, axis, middle, -1)) < share * whole ? low : high) = middle;
    }
    return (low + high) / 2;
  };
  LightPolygon out = polygon;
  if (from > 0) out = cut(out, axis, place(from), 1);
  if (to < 1) out = cut(out, axis, place(to), -1);
  return out;
}

}  // namespace

double area(const LightPolygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

glm::dvec2 centroid(const LightPolygon& polygon) {
  glm::dvec2 sum(0);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    sum += (p + q) * cross(p, q);
  }
  return sum / (6 * area(polygon));
}

LightPolygon outline_of(const Light& light) {
  if (light.kind == LightKind::kRectangle) {
    const glm::dvec2 half = glm::dvec2(light.width_m, light.height_m) * 0.5;
    return {-half, {half.x, -half.y}, half, {-half.x, half.y}};
  }
  constexpr double kStep = 2 * kPi / gpu::DISC_CORNERS;
  const double corner = light.radius_m * std::sqrt(kStep / std::sin(kStep));
  LightPolygon out;
  for (int i = 0; i < int(gpu::DISC_CORNERS); ++i)
    out.push_back(corner * glm::dvec2(std::cos(i * kStep), std::sin(i * kStep)));
  return out;
}

LightPolygon equal_part(const LightPolygon& polygon, int count, int index) {
  glm::dvec2 low = polygon.front(), high = low;
  for (const glm::dvec2& corner : polygon) low = glm::min(low, corner), high = glm::max(high, corner);
  const glm::dvec2 size = high - low;
  const int rows = std::clamp(int(std::lround(std::sqrt(count * size.y / size.x))), 1, count);
  // Rows hold one part more or less than another, and are as much higher.
  const auto first_of = [&](int row) { return int(std::int64_t(count) * row / rows); };
  int row = 0;
  while (first_of(row + 1) <= index) ++row;
  const int first = first_of(row), columns = first_of(row + 1) - first;
  const LightPolygon strip = slice(polygon, 1, double(first) / count, double(first + columns) / count);
  return slice(strip, 0, double(index - first) / columns, double(index - first + 1) / columns);
}

}  // namespace furnace
