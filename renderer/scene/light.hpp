// Lights that are not part of an environment.
#pragma once

#include <numbers>
#include <optional>
#include <string>

#include <glm/glm.hpp>

namespace furnace {

enum class LightKind { kDirectional, kPoint, kSpot };

// KHR_lights_punctual, and the size of what shines. Threads: a value.
struct Light {
  LightKind kind = LightKind::kPoint;
  std::string name;
  glm::dvec3 position{0};          // m, world; kPoint, kSpot
  glm::dvec3 direction{0, -1, 0};  // unit, world, the way the light goes; kDirectional, kSpot
  glm::dvec3 intensity{1};         // linear RGB: lux on a plane that faces a directional light, else candela
  std::optional<double> range_m;   // where it ends smoothly; none: nowhere
  double inner_cone_rad = 0, outer_cone_rad = std::numbers::pi / 4;  // from the axis of a spot
  double radius_m = 0;            // of the sphere or disc that shines; kPoint, kSpot
  double angular_radius_rad = 0;  // of the disc in the sky; kDirectional
  bool casts_shadow = true;
};

}  // namespace furnace
