#include "renderer/scene/lens.hpp"

#include <cmath>
#include <cstdint>
#include <utility>

#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

// Kollig and Keller 2002, "Efficient Multidimensional Sampling": van der Corput's and Sobol's radical inverses in base 2, of
// which every power of two of points fills a grid of any shape evenly. They share nothing with the sequences of the golden
// ratio's kind that pixels and lights are sampled by, so that no place of the lens keeps to one place of these.
glm::dvec2 even_place(std::uint32_t i) {
  std::uint32_t x = 0, y = 0;
  std::uint32_t direction = 1u << 31;
  for (std::uint32_t bit = 0; bit < 32; ++bit, i >>= 1) {
    if (i & 1u) {
      x |= 1u << (31 - bit);
      y ^= direction;
    }
    direction ^= direction >> 1;
  }
  constexpr double kScale = 0x1p-32;
  return {x * kScale, y * kScale};
}

// Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square": share of the way round, and radius.
std::pair<double, double> concentric(glm::dvec2 square) {
  const glm::dvec2 at = 2.0 * square - 1.0;
  if (at == glm::dvec2(0)) return {0, 0};
  if (std::abs(at.x) > std::abs(at.y)) return {(at.y / at.x + (at.x > 0 ? 0 : 4)) / 8, std::abs(at.x)};
  return {(2 - at.x / at.y + (at.y > 0 ? 0 : 4)) / 8, std::abs(at.y)};
}

}  // namespace

Lens make_lens(const DepthOfField& spec, double half_tangent, double focus_m) {
  const double focal_length_m = spec.sensor_height_m / (2 * half_tangent);
  const double diameter_m = spec.aperture_diameter_m.value_or(focal_length_m / spec.f_stop);
  return {diameter_m / 2, focus_m, spec.blades, spec.blade_rotation_rad};
}

glm::dvec2 lens_place(const Lens& lens, int i, int count) {
  if (count == 1) return glm::dvec2(0);
  // In the middle of their cells, the mean is that of the lens.
  const auto [around, radius] = concentric(even_place(std::uint32_t(i)) + 0.5 / count);
  const auto edge = [&](double angle_rad) {
    const double from_up_rad = angle_rad + lens.blade_rotation_rad + kPi / 2;
    return lens.radius_m * glm::dvec2(std::cos(from_up_rad), std::sin(from_up_rad));
  };
  if (lens.blades == 0) return radius * edge(2 * kPi * around);
  // Along each side a polygon's area grows as the way along the edge does: the map from the disc keeps areas.
  const double turned = (around < 0 ? around + 1 : around) * lens.blades;
  const double side = std::floor(turned);
  const double corner_rad = 2 * kPi / lens.blades;
  return radius * glm::mix(edge(side * corner_rad), edge((side + 1) * corner_rad), turned - side);
}

}  // namespace furnace
