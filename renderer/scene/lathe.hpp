// Surfaces of revolution about +Y from a profile of tangent arcs and lines, with analytic normals and
// tangents.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/scene.hpp"

namespace furnace {

struct ProfilePoint {
  double radius = 0, height = 0;  // m
  double normal_rad =
      0;  // the outward normal turned from +Y towards the outside: pi/2 is outward, pi is down
};

// Draws a profile like a pen that moves along the surface with the outside on its left, from the top outwards
// and down. Arcs start where the last step ended, in its direction, so a profile has no edge unless `edge`
// makes one.
class Profile {
 public:
  explicit Profile(ProfilePoint start) : points_{start} {}

  // An arc until the normal points to `normal_rad`; positive radii bulge outwards (the angle grows), negative
  // ones are hollow (it shrinks). Split so finely that chords stay within 0.1 mm of the arc and turn at most
  // 10 degrees.
  Profile& turn(double arc_radius, double to_normal_rad);
  Profile& forward(double length);
  Profile& forward_to_radius(double radius);
  // Turns on the spot: a sharp edge.
  Profile& edge(double to_normal_rad);
  // Joins the end of a ring profile to its start exactly, past the rounding of all its steps.
  Profile& close();
  // Raises or lowers all points.
  Profile& shift(double height);

  const ProfilePoint& end() const { return points_.back(); }
  const std::vector<ProfilePoint>& points() const { return points_; }

 private:
  std::vector<ProfilePoint> points_;
};

// Where the turned body stands in the mesh's space.
struct Placement {
  glm::dmat3 rotation{1};
  glm::dvec3 origin{0};
};

// Turns the profile in `segments` steps. u grows counter-clockwise seen from above and is 0.5 at +Z; v runs
// along the profile from 0 to 1 by arc length. Seams and poles share positions exactly, so the surface is
// watertight.
Mesh lathe(std::string name, const Profile& profile, int segments, const Placement& placement = {});

}  // namespace furnace
