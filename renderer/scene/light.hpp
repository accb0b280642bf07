// Lights that are not part of an environment.
#pragma once

#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "renderer/scene/light_profile.hpp"

namespace furnace {

// The last three are surfaces that shine as bright from every side: Lambert's emitters.
enum class LightKind { kDirectional, kPoint, kSpot, kSphere, kDisc, kRectangle };

// KHR_lights_punctual, and the size of what shines. Threads: a value.
struct Light {
  LightKind kind = LightKind::kPoint;
  std::string name;
  glm::dvec3 position{0};  // m, world: the middle; all but kDirectional
  glm::dvec3 direction{
      0, -1, 0};  // unit, world, the way the light goes; all but kSphere and a kPoint without a profile
  glm::dvec3 intensity{
      1};  // linear RGB: lux on a plane that faces a directional light, nits of a surface, else candela
  std::optional<double> range_m;                                     // where it ends smoothly; none: nowhere
  double inner_cone_rad = 0, outer_cone_rad = std::numbers::pi / 4;  // from the axis of a spot
  double radius_m = 0;               // of the sphere or disc that shines; all but kDirectional, kRectangle
  double angular_radius_rad = 0;     // of the disc in the sky; kDirectional
  double width_m = 1, height_m = 1;  // kRectangle: along axes_of_light()
  double roll_rad = 0;  // of a rectangle or a profile about `direction`, counter-clockwise against the light
  bool two_sided = false;  // kDisc, kRectangle
  // kPoint: by how much `intensity` is to be multiplied towards each side, 1 at most; null: 1.
  std::shared_ptr<const LightProfile> profile;
  bool casts_shadow = true;

  bool is_surface() const { return kind >= LightKind::kSphere; }
};

// The way the light goes is -z: x lies level, to the right of who looks against the light, y upwards, before the roll. Of a light
// that goes straight up or down x is +X.
struct LightAxes {
  glm::dvec3 x, y;
};
LightAxes axes_of_light(const Light& light);

// m^2: of all that shines; 0 where nothing but a place or a direction does.
double light_area_m2(const Light& light);

}  // namespace furnace
