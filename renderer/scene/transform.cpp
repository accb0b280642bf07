#include "renderer/scene/transform.hpp"

#include <cmath>

namespace furnace {
namespace {

// glTF's default camera looks down -Z.
glm::dvec3 direction_or(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return length > 0 ? v / length : otherwise;
}

glm::dvec3 right_of(const glm::dvec3& forward, const glm::dvec3& up) {
  // Below this sine the direction of the cross product is rounding noise of float input.
  constexpr double kParallel = 1e-6;
  const glm::dvec3 right = glm::cross(forward, direction_or(up, forward));
  if (glm::length(right) > kParallel) return glm::normalize(right);
  const bool vertical = std::abs(forward.y) > 0.9;
  const glm::dvec3 other = vertical ? glm::dvec3(0, 0, std::copysign(1.0, forward.y)) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(forward, other));
}

}  // namespace

glm::mat4 view_from_axes(const glm::dmat3& axes, const glm::dvec3& eye) {
  const glm::dmat3 rotation = glm::transpose(axes);
  glm::dmat4 view(rotation);
  view[3] = glm::dvec4(-(rotation * eye), 1);
  return glm::mat4(view);
}

glm::mat4 look_at(const glm::vec3& eye, const glm::vec3& target, const glm::vec3& up) {
  const glm::dvec3 forward = direction_or(glm::dvec3(target) - glm::dvec3(eye), {0, 0, -1});
  const glm::dvec3 right = right_of(forward, glm::dvec3(up));
  return view_from_axes({right, glm::cross(right, forward), -forward}, glm::dvec3(eye));
}

glm::mat4 perspective_reversed(double fov_y_rad, double aspect, double z_near, double z_far) {
  const double scale = 1 / std::tan(fov_y_rad / 2);
  const bool infinite = std::isinf(z_far);
  glm::dmat4 clip(0);
  clip[0][0] = scale / aspect;
  clip[1][1] = scale;
  clip[2][2] = infinite ? 0 : z_near / (z_far - z_near);
  clip[2][3] = -1;
  clip[3][2] = infinite ? z_near : z_far * z_near / (z_far - z_near);
  return glm::mat4(clip);
}

glm::mat4 orthographic_reversed(double half_width, double half_height, double z_near, double z_far) {
  glm::dmat4 clip(1);
  clip[0][0] = 1 / half_width;
  clip[1][1] = 1 / half_height;
  clip[2][2] = 1 / (z_far - z_near);
  clip[3][2] = z_far / (z_far - z_near);
  return glm::mat4(clip);
}

}  // namespace furnace
