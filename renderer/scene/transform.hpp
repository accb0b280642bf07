// Conventions: right-handed, +Y up, metres, camera looks down -Z of its view space (glTF 2.0). Matrices are
// named b_from_a and read right to left: clip_from_world = clip_from_view * view_from_world. GLM, column
// major. Clip space is GL's with clip control ZERO_TO_ONE and reversed depth: near plane -> 1, infinity -> 0.
#pragma once

#include <numbers>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace furnace {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double radians_from_degrees(double degrees) {
  return degrees * kPi / 180;
}

// view_from_world of an eye with unit, orthogonal axes given in world space: columns right, up, back (away
// from the scene). Worked out in double: a far eye costs no precision before the final rounding.
glm::mat4 view_from_axes(const glm::dmat3& axes, const glm::dvec3& eye);

// view_from_world of an eye that looks at `target`, which must differ from it; when `up` is parallel to the
// view (or zero), +Y serves, and for a vertical view -Z (down) or +Z (up), as if the eye had tilted there
// from +Z.
glm::mat4 look_at(const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up);

// Reversed-depth perspective; z_far may be infinite. fov_y_rad in (0, pi).
glm::mat4 perspective_reversed(double fov_y_rad, double aspect, double z_near, double z_far);
// Reversed-depth orthographic; half extents in metres.
glm::mat4 orthographic_reversed(double half_width, double half_height, double z_near, double z_far);

}  // namespace furnace
