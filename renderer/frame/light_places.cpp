#include "renderer/frame/light_places.hpp"

#include <cmath>

#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

double fraction(double x) {
  return x - std::floor(x);
}

// Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": of his sequence in four dimensions the last two, so
// that it does not go hand in hand with the places in the pixel, which are his two.
glm::dvec2 square_place(int i) {
  constexpr double kRoot = 1.16730397826141868;  // of x^5 = x + 1
  return {fraction(0.5 + i / std::pow(kRoot, 3)), fraction(0.5 + i / std::pow(kRoot, 4))};
}

}  // namespace

glm::dvec2 disc_place(int i) {
  const glm::dvec2 place = square_place(i);
  const double radius = std::sqrt(place.x), angle = 2 * kPi * place.y;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

// By Abel's transform of an even disc their density is 1 / sqrt(1 - r^2), so with r = sin t the share within t is
// (2 t - sin 2t) / pi.
glm::dvec3 ball_place(int i) {
  constexpr double kRoot = 1.22074408460575947536;  // of x^4 = x + 1: Roberts' sequence in three dimensions
  const double share = fraction(0.5 + i / kRoot);
  double low = 0, high = kPi / 2;
  for (int step = 0; step < 50; ++step) {
    const double middle = (low + high) / 2;
    (2 * middle - std::sin(2 * middle) < share * kPi ? low : high) = middle;
  }
  const double up = 2 * fraction(0.5 + i / (kRoot * kRoot)) - 1, across = std::sqrt(1 - up * up);
  const double angle = 2 * kPi * fraction(0.5 + i / (kRoot * kRoot * kRoot));
  return std::sin(low) * glm::dvec3(across * std::cos(angle), up, across * std::sin(angle));
}

glm::dvec3 place_on(const Light& light, int i) {
  const LightAxes axes = axes_of_light(light);
  glm::dvec2 across(0);
  switch (light.kind) {
    case LightKind::kPoint:
    case LightKind::kSphere:
      return light.position + light.radius_m * ball_place(i);
    case LightKind::kRectangle:
      across = (square_place(i) - 0.5) * glm::dvec2(light.width_m, light.height_m);
      break;
    case LightKind::kSpot:
    case LightKind::kDisc:
    case LightKind::kDirectional:
      across = light.radius_m * disc_place(i);
      break;
  }
  return light.position + axes.x * across.x + axes.y * across.y;
}

double extent_m(const Light& light) {
  return light.kind == LightKind::kRectangle ? glm::length(glm::dvec2(light.width_m, light.height_m)) / 2
                                             : light.radius_m;
}

}  // namespace furnace
