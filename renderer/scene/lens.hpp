// A thin lens: where on it each sub-frame's eye is.
#pragma once

#include <glm/glm.hpp>

#include "renderer/scene/render_spec.hpp"

namespace furnace {

// Threads: a value.
struct Lens {
  double radius_m = 0;  // 0: a pinhole
  double focus_m = 1;   // distance of the plane of focus along the viewing direction, > 0
  int blades = 0;       // as DepthOfField
  double blade_rotation_rad = 0;
};

// Of a perspective camera. `half_tangent`: of half its vertical field of view.
Lens make_lens(const DepthOfField& spec, double half_tangent, double focus_m);

// Place i of `count` on the lens, m right and up of its middle; together they cover it evenly. One alone is the middle.
glm::dvec2 lens_place(const Lens& lens, int i, int count);

}  // namespace furnace
