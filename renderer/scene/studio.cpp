#include "renderer/scene/studio.hpp"

#include "renderer/scene/equirect_painter.hpp"
#include "renderer/scene/transform.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace furnace {
namespace {

constexpr Extent kExtent{1024, 512};

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// --- The room
// -------------------------------------------------------------------------------------------------------

// Radiance by elevation: a floor that catches the light, a sweep up into darker walls, a dim ceiling.
struct Shade {
  double elevation_deg, radiance;
};
constexpr std::array kRoom = {
    Shade{-90, 0.24}, Shade{-40, 0.27}, Shade{-12, 0.24}, Shade{4, 0.16},
    Shade{24, 0.10},  Shade{55, 0.09},  Shade{90, 0.14},
};

double room_radiance(double elevation_deg) {
  std::size_t i = 1;
  while (i + 1 < kRoom.size() && elevation_deg > kRoom[i].elevation_deg) ++i;
  const Shade &below = kRoom[i - 1], &above = kRoom[i];
  const double t = smoothstep(below.elevation_deg, above.elevation_deg, elevation_deg);
  return below.radiance + t * (above.radiance - below.radiance);
}

// A pool of light on the backdrop behind the model, seen from the default camera.
constexpr double kPoolAzimuth = radians_from_degrees(213), kPoolElevation = radians_from_degrees(-12);
constexpr double kPoolRadiance = 0.30;
constexpr double kPoolSharpnessAzimuth = 11,
                 kPoolSharpnessElevation = 15;  // as exp(sharpness * (cos(angle) - 1))

// --- The lights
// -----------------------------------------------------------------------------------------------------

// A flat, feathered rectangle of light, painted as the eye at the centre sees it (gnomonic projection), so
// that a mirror shows straight edges.
struct SoftBox {
  double azimuth_deg, elevation_deg, roll_deg;
  double half_width, half_height;  // tangents of the half angles
  double feather;                  // width of the soft edge, in the same unit
  double core;                     // brightness of the middle against the border, which is 1
  glm::dvec3 radiance;
};

constexpr std::array kLights = {
    // Key: high on the left of the default camera.
    SoftBox{-23, 38, -8, 0.42, 0.34, 0.09, 2.0, {5.0, 4.90, 4.74}},
    // Fill: a wide, weak wall of light on the right.
    SoftBox{104, 14, 0, 0.48, 0.72, 0.30, 1.3, {0.78, 0.81, 0.86}},
    // Rim: a tall strip behind, right of the backdrop.
    SoftBox{164, 25, 5, 0.055, 0.55, 0.03, 1.2, {15.5, 16.0, 16.6}},
    // Kicker: its weaker twin on the other side.
    SoftBox{-96, 22, -4, 0.07, 0.52, 0.04, 1.2, {7.4, 7.6, 8.0}},
    // Top: a scrim under the ceiling.
    SoftBox{215, 74, 0, 0.70, 0.20, 0.12, 1.5, {1.2, 1.2, 1.2}},
};

double soft_edge(double offset, double half_size, double feather) {
  return 1 - smoothstep(half_size - feather, half_size, std::abs(offset));
}

// Of the light's radiance in a direction with the given plane coordinates.
double light_pattern(const SoftBox& light, double x, double y) {
  const double edge =
      soft_edge(x, light.half_width, light.feather) * soft_edge(y, light.half_height, light.feather);
  const double u = x / light.half_width, v = y / light.half_height;
  const double falloff = std::max(0.0, 1 - 0.5 * (u * u + v * v));
  return edge * (1 + (light.core - 1) * falloff * falloff);
}

// --- The picture
// ----------------------------------------------------------------------------------------------------

using Row = std::vector<glm::dvec3>;

// The pool of light is a product of a lobe by column and one by row: two tables instead of an exponential per
// texel.
class Room {
 public:
  explicit Room(const EquirectGrid& grid) : grid_(grid) {
    for (int column = 0; column < grid.extent.width; ++column) {
      const double toward =
          grid.cos_phi[column] * std::sin(kPoolAzimuth) + grid.sin_phi[column] * std::cos(kPoolAzimuth);
      pool_by_column_.push_back(std::exp(kPoolSharpnessAzimuth * (toward - 1)));
    }
  }

  void paint(int row, Row& radiance) const {
    const double elevation = kPi / 2 - kPi * (row + 0.5) / grid_.extent.height;
    const double room = room_radiance(elevation * 180 / kPi);
    const double pool =
        kPoolRadiance * std::exp(kPoolSharpnessElevation * (std::cos(elevation - kPoolElevation) - 1));
    for (int column = 0; column < grid_.extent.width; ++column)
      radiance[column] = glm::dvec3(room + pool * pool_by_column_[column]);
  }

 private:
  const EquirectGrid& grid_;
  std::vector<double> pool_by_column_;
};

// A light with its plane's axes, to the right and up as seen from the centre.
class Lamp {
 public:
  explicit Lamp(const SoftBox& box)
      : box_(box),
        cos_reach_(1 / std::sqrt(1 + box.half_width * box.half_width + box.half_height * box.half_height)) {
    const double azimuth = radians_from_degrees(box.azimuth_deg), roll = radians_from_degrees(box.roll_deg);
    forward_ = direction_of(azimuth, radians_from_degrees(box.elevation_deg));
    const glm::dvec3 level(-std::cos(azimuth), 0, std::sin(azimuth));
    const glm::dvec3 upright = glm::cross(level, forward_);
    right_ = std::cos(roll) * level + std::sin(roll) * upright;
    up_ = std::cos(roll) * upright - std::sin(roll) * level;
  }

  void paint(const EquirectGrid& grid, int row, Row& radiance) const {
    if (!reaches(grid, row)) return;
    for (int column = 0; column < grid.extent.width; ++column) {
      const glm::dvec3 direction = grid.direction(row, column);
      const double depth = glm::dot(direction, forward_);
      if (depth < cos_reach_) continue;
      const double x = glm::dot(direction, right_) / depth, y = glm::dot(direction, up_) / depth;
      radiance[column] += light_pattern(box_, x, y) * box_.radiance;
    }
  }

 private:
  // The largest cosine between a row's directions and the light's axis is the one in the axis' own meridian.
  bool reaches(const EquirectGrid& grid, int row) const {
    const double level = std::hypot(forward_.x, forward_.z);
    return grid.cos_theta[row] * forward_.y + grid.sin_theta[row] * level >= cos_reach_;
  }

  const SoftBox& box_;
  double cos_reach_;
  glm::dvec3 forward_, right_, up_;
};

}  // namespace

Image make_studio() {
  const EquirectGrid grid(kExtent);
  const Room room(grid);
  const std::vector<Lamp> lamps(kLights.begin(), kLights.end());
  return paint_equirect(kExtent, [&](int row, Row& radiance) {
    room.paint(row, radiance);
    for (const Lamp& lamp : lamps) lamp.paint(grid, row, radiance);
  });
}

}  // namespace furnace
