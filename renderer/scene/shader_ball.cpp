#include "renderer/scene/shader_ball.hpp"

#include "renderer/scene/lathe.hpp"
#include "renderer/scene/transform.hpp"

#include <cmath>

namespace furnace {
namespace {

constexpr int kSegments = 128;

// Metres. A band is let into the orb, flush but for a shadow gap, around a tilted axis: from any side the orb
// shows its broad curve, its rounded edges and the hollow between orb and band.
constexpr double kOrbRadius = 0.45;
constexpr double kGrooveAngle = radians_from_degrees(64);  // of the groove's middle from the orb's pole
constexpr double kGrooveHalfWidth = 0.030, kGrooveDepth = 0.030;
constexpr double kEdgeRadius = 0.009;
constexpr double kBandRecess = 0.004;  // below the orb's surface
constexpr double kBandGap = 0.006;     // to each wall of the groove
constexpr double kCupGap = 0.008;      // between the orb and its pedestal

// Half the angle that a strip takes of a round surface when its walls, parallel to the radius through its
// middle, stand `half_width` from it and meet the surface in arcs of radius `edge` (negative: the strip lies
// outside the walls).
double half_angle(double half_width, double surface_radius, double edge) {
  return std::asin((half_width - edge) / (surface_radius - std::abs(edge)));
}

Profile orb_profile() {
  constexpr double kCorner = 0.004, kQuarter = kPi / 2;
  const double half = half_angle(kGrooveHalfWidth, kOrbRadius, -kEdgeRadius);
  Profile profile({0, kOrbRadius, 0});
  profile.turn(kOrbRadius, kGrooveAngle - half)
      .turn(kEdgeRadius, kGrooveAngle + kQuarter)
      .forward(kGrooveDepth)
      .turn(-kCorner, kGrooveAngle)
      .forward(2 * (kGrooveHalfWidth - kCorner))
      .turn(-kCorner, kGrooveAngle - kQuarter)
      .forward(kGrooveDepth)
      .turn(kEdgeRadius, kGrooveAngle + half)
      .turn(kOrbRadius, kPi);
  return profile;
}

// Closed; it starts at the middle of its underside, where nobody looks.
Profile band_profile() {
  constexpr double kHeight = 0.010, kQuarter = kPi / 2, kUnderside = kGrooveAngle - kPi;
  constexpr double kHalfWidth = kGrooveHalfWidth - kBandGap, kTop = kOrbRadius - kBandRecess;
  const double half = half_angle(kHalfWidth, kTop, kEdgeRadius);
  // Of the top edges' centres above the orb's.
  const double corner_height = (kTop - kEdgeRadius) * std::cos(half);
  const double underside = corner_height - kHeight - kEdgeRadius;
  Profile profile({underside * std::sin(kGrooveAngle), underside * std::cos(kGrooveAngle), kUnderside});
  profile.forward(kHalfWidth - kEdgeRadius)
      .turn(kEdgeRadius, kGrooveAngle - kQuarter)
      .forward(kHeight)
      .turn(kEdgeRadius, kGrooveAngle - half)
      .turn(kTop, kGrooveAngle + half)
      .turn(kEdgeRadius, kGrooveAngle + kQuarter)
      .forward(kHeight)
      .turn(kEdgeRadius, kGrooveAngle + kPi)
      .forward(kHalfWidth - kEdgeRadius)
      .close();
  return profile;
}

// Cup, lip, flared neck, plinth. The cup is concentric with the orb, whose centre is the profile's origin
// until all is lowered onto the floor.
struct Pedestal {
  Profile profile;
  double orb_height;
};

Pedestal make_pedestal() {
  constexpr double kCupAngle = radians_from_degrees(29);
  constexpr double kPlinthRadius = 0.38, kPlinthHeight = 0.045, kBevel = 0.010;
  Profile profile({0, -(kOrbRadius + kCupGap), 0});
  profile.turn(-(kOrbRadius + kCupGap), -kCupAngle)
      .turn(0.010, radians_from_degrees(82))
      .turn(-0.075, radians_from_degrees(0))
      .forward_to_radius(kPlinthRadius - kBevel)
      .turn(kBevel, radians_from_degrees(90))
      .forward(kPlinthHeight - 2 * kBevel)
      .turn(kBevel, radians_from_degrees(180))
      .forward_to_radius(0);
  const double orb_height = -profile.end().height;
  profile.shift(orb_height);
  return {profile, orb_height};
}

// Tips the orb's axis towards a viewer at the default camera's side, leaning to the picture's left.
glm::dmat3 orb_rotation() {
  const double tilt = radians_from_degrees(30), azimuth = radians_from_degrees(-12);
  const glm::dvec3 axis(std::sin(azimuth) * std::sin(tilt), std::cos(tilt),
                        std::cos(azimuth) * std::sin(tilt));
  const glm::dvec3 right = glm::normalize(glm::cross(axis, glm::dvec3(0, 0, 1)));
  return {right, axis, glm::cross(right, axis)};
}

}  // namespace

std::vector<Mesh> make_shader_ball() {
  const Pedestal pedestal = make_pedestal();
  const Placement orb{orb_rotation(), {0, pedestal.orb_height, 0}};
  std::vector<Mesh> meshes;
  meshes.push_back(lathe("body", orb_profile(), kSegments, orb));
  meshes.push_back(lathe("core", band_profile(), kSegments, orb));
  meshes.push_back(lathe("base", pedestal.profile, kSegments));
  return meshes;
}

}  // namespace furnace
