// How near an eye may stand to what it must see: tight framing by support planes. Each side plane of the frame is pushed
// against the points, opposite planes meet in a line of possible eyes, and the farther of both axes' lines decides.
#pragma once

#include <functional>
#include <limits>

#include <glm/glm.hpp>

namespace furnace {

// The point that a frame plane touches first: it maximises +-a + slope * z, a = x or y.
struct Touch {
  double reach = -std::numeric_limits<double>::infinity();
  double a = 0, z = 0;

  void add(double point_reach, double point_a, double point_z) {
    if (point_reach > reach) *this = {point_reach, point_a, point_z};
  }
};

// Both frame planes of one picture axis: all points satisfy +-a <= reach - slope * z.
struct Slab {
  Touch plus, minus;

  void add(double slope, double a, double z) {
    plus.add(a + slope * z, a, z);
    minus.add(-a + slope * z, a, z);
  }
  // The nearest eye depth at which both planes of this slope pass through one point outside.
  double eye_z(double slope) const { return (plus.reach + minus.reach) / (2 * slope); }
  double centre() const { return (plus.reach - minus.reach) / 2; }
};

struct Slopes {
  double x, y;  // tangents of the half angles of view, divided by `fit`; 0: parallel projection
};

// Of points in the camera's axes: x to the right, y up, z to the eye.
struct Support {
  Slopes slopes;
  Slab x, y;
  double z_min = std::numeric_limits<double>::infinity(), z_max = -std::numeric_limits<double>::infinity();

  void add_depth(double z) {
    if (z < z_min) z_min = z;
    if (z > z_max) z_max = z;
  }
  // The diagonal of what is seen, its width and height those of the frame at the farthest point; 1 m for a single point,
  // which has no scale of its own.
  double size() const;
};

using SupportOf = std::function<Support(Slopes)>;

// Of a scene's size: an eye this near still has a sound near plane, and no usual picture notices (it takes a spike that
// points at the eye, or an angle of view beyond 170 degrees).
inline constexpr double kClearance = 1e-3;

struct Stand {
  glm::dvec3 eye{0};     // in the camera's axes
  double z_min, z_max;   // of what is seen
  double half_height_m;  // of the frame of a parallel projection
  double size_m;         // of what is seen
};

// What is seen is centred in the picture. `slopes` > 0.
Stand perspective_stand(const SupportOf& support_of, Slopes slopes);
Stand parallel_stand(const SupportOf& support_of, double aspect, double fit);

}  // namespace furnace
