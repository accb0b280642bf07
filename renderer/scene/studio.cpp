#include "renderer/scene/studio.hpp"

#include "renderer/scene/equirect_painter.hpp"
#include "renderer/scene/gradient.hpp"
#include "renderer/image/color.hpp"

#include <algorithm>
#include <cmath>

namespace furnace {
namespace {

using Row = std::vector<glm::dvec3>;

// --- The lights
// -----------------------------------------------------------------------------------------------------

// A light in the plane that it lies in, 1 m from the centre.
class Lamp {
 public:
  explicit Lamp(const SoftBox& box)
      : shape_(box.shape),
        half_(std::tan(box.width_rad / 2), std::tan(box.height_rad / 2)),
        feather_(box.feather * std::min(half_.x, half_.y)),
        hotspot_(box.hotspot),
        radiance_(box.color * (box.luminance / luminance_rec709(box.color.r, box.color.g, box.color.b))),
        cos_reach_(1 / std::sqrt(1 + half_.x * half_.x + half_.y * half_.y)) {
    forward_ = direction_of(box.azimuth_rad, box.elevation_rad);
    const glm::dvec3 level(-std::cos(box.azimuth_rad), 0, std::sin(box.azimuth_rad));
    const glm::dvec3 upright = glm::cross(level, forward_);
    right_ = std::cos(box.roll_rad) * level + std::sin(box.roll_rad) * upright;
    up_ = std::cos(box.roll_rad) * upright - std::sin(box.roll_rad) * level;
  }

  void paint(const EquirectGrid& grid, int row, Row& radiance) const {
    // A texel whose centre lies outside may still be crossed by the edge.
    const double reach = std::acos(cos_reach_) + grid.texel_radius_rad();
    const double cos_reach = std::max(std::cos(std::min(reach, kPi)), kLeastDepth);
    // The largest cosine between a row's directions and the light's axis is the one in the axis' own meridian.
    const double level = std::hypot(forward_.x, forward_.z);
    if (grid.cos_theta[row] * forward_.y + grid.sin_theta[row] * level < cos_reach) return;
    for (int column = 0; column < grid.extent.width; ++column) {
      const glm::dvec3 direction = grid.direction(row, column);
      const double depth = glm::dot(direction, forward_);
      if (depth < cos_reach) continue;
      // A small angle is seen in the plane at most so much larger.
      const double texel_reach = grid.texel_radius_rad() / (depth * depth);
      const glm::dvec2 place = glm::dvec2(glm::dot(direction, right_), glm::dot(direction, up_)) / depth;
      const bool sharp = feather_ < kSoftTexels * texel_reach && std::abs(inset(place)) < 2 * texel_reach;
      radiance[column] += (sharp ? mean_pattern(grid, row, column) : pattern(place)) * radiance_;
    }
  }

  // In the middle of the light, where the plane is not stretched.
  bool needs_fine_grid(const EquirectGrid& grid) const {
    return feather_ < kSoftTexels * grid.texel_radius_rad();
  }

 private:
  static constexpr double kSoftTexels = 4;      // an edge as wide as that shows no stairs
  static constexpr double kLeastDepth = 0.017;  // 1 degree off the plane: lights end before

  // Signed distance from the edge, inwards; outside of a corner and of an ellipse a lower bound.
  double inset(const glm::dvec2& place) const {
    if (shape_ == LightShape::kRectangle)
      return std::min(half_.x - std::abs(place.x), half_.y - std::abs(place.y));
    return (1 - glm::length(place / half_)) * std::min(half_.x, half_.y);
  }

  // Part of the light's radiance at a place in its plane.
  double pattern(const glm::dvec2& place) const {
    double edge = 1;
    if (shape_ == LightShape::kRectangle)
      edge = fade(half_.x - std::abs(place.x)) * fade(half_.y - std::abs(place.y));
    else
      edge = fade(inset(place));
    const double u = place.x / half_.x, v = place.y / half_.y;
    const double falloff = std::max(0.0, 1 - 0.5 * (u * u + v * v));
    return edge * (1 + (hotspot_ - 1) * falloff * falloff);
  }

  double fade(double inset) const {
    if (feather_ == 0) return inset >= 0 ? 1 : 0;
    return 1 - smoothstep(-feather_, 0, -inset);
  }

  double mean_pattern(const EquirectGrid& grid, int row, int column) const {
    return grid.mean_over_texel(row, column, [&](const glm::dvec3& direction) {
      const double depth = glm::dot(direction, forward_);
      if (depth <= 0) return 0.0;
      return pattern(glm::dvec2(glm::dot(direction, right_), glm::dot(direction, up_)) / depth);
    });
  }

  LightShape shape_;
  glm::dvec2 half_;  // m
  double feather_;   // width of the soft edge, m
  double hotspot_;
  glm::dvec3 radiance_;
  double cos_reach_;
  glm::dvec3 forward_, right_, up_;
};

template <class PaintRoom>
Image paint(const std::vector<SoftBox>& lights, const EquirectGrid& grid, PaintRoom&& paint_room) {
  const std::vector<Lamp> lamps(lights.begin(), lights.end());
  return paint_equirect(grid.extent, [&](int row, Row& radiance) {
    paint_room(row, radiance);
    for (const Lamp& lamp : lamps) lamp.paint(grid, row, radiance);
  });
}

// --- The default
// -----------------------------------------------------------------------------------------------------

// A pool of light on the backdrop behind the model, seen from the default camera: a product of a lobe by
// column and one by row, exp(sharpness * (cos(angle) - 1)), so two tables instead of an exponential per texel.
class Pool {
 public:
  explicit Pool(const EquirectGrid& grid) : grid_(grid) {
    for (int column = 0; column < grid.extent.width; ++column) {
      const double toward =
          grid.cos_phi[column] * std::sin(kAzimuth) + grid.sin_phi[column] * std::cos(kAzimuth);
      by_column_.push_back(std::exp(kSharpnessAzimuth * (toward - 1)));
    }
  }

  void paint(int row, Row& radiance) const {
    const double elevation = grid_.elevation_rad(row);
    const double by_row = kRadiance * std::exp(kSharpnessElevation * (std::cos(elevation - kElevation) - 1));
    for (int column = 0; column < grid_.extent.width; ++column)
      radiance[column] += by_row * by_column_[column];
  }

 private:
  static constexpr double kAzimuth = radians_from_degrees(213), kElevation = radians_from_degrees(-12);
  static constexpr double kSharpnessAzimuth = 11, kSharpnessElevation = 15, kRadiance = 0.30;

  const EquirectGrid& grid_;
  std::vector<double> by_column_;
};

SoftBox box(double azimuth_deg, double elevation_deg, double roll_deg, const glm::dvec2& half_tangents,
            double feather_tangent, double hotspot, const glm::dvec3& radiance) {
  return {.azimuth_rad = radians_from_degrees(azimuth_deg),
          .elevation_rad = radians_from_degrees(elevation_deg),
          .roll_rad = radians_from_degrees(roll_deg),
          .width_rad = 2 * std::atan(half_tangents.x),
          .height_rad = 2 * std::atan(half_tangents.y),
          .color = radiance,
          .luminance = luminance_rec709(radiance.r, radiance.g, radiance.b),
          .feather = feather_tangent / std::min(half_tangents.x, half_tangents.y),
          .hotspot = hotspot};
}

std::vector<SoftBox> builtin_lights() {
  return {
      // Key: high on the left of the default camera.
      box(-23, 38, -8, {0.42, 0.34}, 0.09, 2.0, {5.0, 4.90, 4.74}),
      // Fill: a wide, weak wall of light on the right.
      box(104, 14, 0, {0.48, 0.72}, 0.30, 1.3, {0.78, 0.81, 0.86}),
      // Rim: a tall strip behind, right of the backdrop.
      box(164, 25, 5, {0.055, 0.55}, 0.03, 1.2, {15.5, 16.0, 16.6}),
      // Kicker: its weaker twin on the other side.
      box(-96, 22, -4, {0.07, 0.52}, 0.04, 1.2, {7.4, 7.6, 8.0}),
      // Top: a scrim under the ceiling.
      box(215, 74, 0, {0.70, 0.20}, 0.12, 1.5, {1.2, 1.2, 1.2}),
  };
}

}  // namespace

GradientEnvironment default_room() {
  GradientEnvironment room;
  room.stops = {{-90, glm::dvec3(0.24)}, {-40, glm::dvec3(0.27)}, {-12, glm::dvec3(0.24)},
                {4, glm::dvec3(0.16)},   {24, glm::dvec3(0.10)},  {55, glm::dvec3(0.09)},
                {90, glm::dvec3(0.14)}};
  room.blend = GradientBlend::kSmooth;
  return room;
}

std::vector<SoftBox> default_soft_boxes() {
  return std::vector<SoftBox>(1);
}

Image paint_studio(const StudioEnvironment& studio) {
  const EquirectGrid coarse(kEquirectExtent);
  const bool fine = std::any_of(studio.lights.begin(), studio.lights.end(),
                                [&](const SoftBox& light) { return Lamp(light).needs_fine_grid(coarse); });
  const EquirectGrid grid(fine ? kFineEquirectExtent : kEquirectExtent);
  return paint(studio.lights, grid, [&](int row, Row& radiance) {
    std::fill(radiance.begin(), radiance.end(), gradient_radiance(studio.room, grid.elevation_deg(row)));
  });
}

Image make_studio() {
  const GradientEnvironment room = default_room();
  const EquirectGrid grid(kEquirectExtent);
  const Pool pool(grid);
  return paint(builtin_lights(), grid, [&](int row, Row& radiance) {
    std::fill(radiance.begin(), radiance.end(), gradient_radiance(room, grid.elevation_deg(row)));
    pool.paint(row, radiance);
  });
}

}  // namespace furnace
