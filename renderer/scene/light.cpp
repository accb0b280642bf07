#include "renderer/scene/light.hpp"

#include <cmath>

namespace furnace {

LightAxes axes_of_light(const Light& light) {
  const glm::dvec3 z = -light.direction;
  const glm::dvec3 level = glm::cross(glm::dvec3(0, 1, 0), z);
  const glm::dvec3 right = glm::length(level) > 1e-6 ? glm::normalize(level) : glm::dvec3(1, 0, 0);
  const glm::dvec3 up = glm::cross(z, right);
  const double cosine = std::cos(light.roll_rad), sine = std::sin(light.roll_rad);
  return {cosine * right + sine * up, cosine * up - sine * right};
}

double light_area_m2(const Light& light) {
  constexpr double kPi = std::numbers::pi;
  const double disc = kPi * light.radius_m * light.radius_m;
  const double sides = light.two_sided ? 2 : 1;
  switch (light.kind) {
    case LightKind::kSphere:
      return 4 * disc;
    case LightKind::kDisc:
      return sides * disc;
    case LightKind::kRectangle:
      return sides * light.width_m * light.height_m;
    case LightKind::kDirectional:
    case LightKind::kPoint:
    case LightKind::kSpot:
      break;
  }
  return 0;
}

}  // namespace furnace
