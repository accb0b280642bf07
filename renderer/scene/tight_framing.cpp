#include "renderer/scene/tight_framing.hpp"

#include <algorithm>
#include <cmath>

namespace furnace {
namespace {

// The slope at which the planes of an axis meet at the depth `eye_z`. The gap between planes is a convex,
// piecewise linear function of the slope, so that Newton's steps reach its root exactly after a few
// (Dinkelbach 1967, "On nonlinear fractional programming", for the same iteration).
double touching_slope(const Slab& slab, double eye_z) {
  const double depths = 2 * eye_z - slab.plus.z - slab.minus.z;
  return std::max(0.0, (slab.plus.a - slab.minus.a) / depths);
}

// Centres the picture: where the eye stands off farther than an axis needs, that axis' planes are narrowed
// until they touch.
Support centred_support(const SupportOf& support_of, Support support, double eye_z) {
  constexpr int kSteps = 16;
  for (int i = 0; i < kSteps; ++i) {
    const Slopes last = support.slopes,
                 next{touching_slope(support.x, eye_z), touching_slope(support.y, eye_z)};
    const double change = std::max(std::abs(next.x - last.x), std::abs(next.y - last.y));
    if (change <= 1e-9 * std::max(last.x, last.y)) break;
    support = support_of(next);
  }
  return support;
}

}  // namespace

double Support::size() const {
  const double width = x.plus.reach + x.minus.reach - 2 * slopes.x * z_min;
  const double height = y.plus.reach + y.minus.reach - 2 * slopes.y * z_min;
  const double diagonal = std::hypot(width, height, z_max - z_min);
  const double rounding = 1e-12 * (std::abs(x.plus.reach) + std::abs(y.plus.reach) + std::abs(z_max));
  return diagonal > rounding ? diagonal : 1;
}

Stand perspective_stand(const SupportOf& support_of, Slopes slopes) {
  const Support tight = support_of(slopes);
  const double size_m = tight.size();
  const double eye_z =
      std::max({tight.x.eye_z(slopes.x), tight.y.eye_z(slopes.y), tight.z_max + kClearance * size_m});
  const Support support = centred_support(support_of, tight, eye_z);
  return {{support.x.centre(), support.y.centre(), eye_z}, tight.z_min, tight.z_max, 0, size_m};
}

Stand parallel_stand(const SupportOf& support_of, double aspect, double fit) {
  const Support box = support_of({0, 0});
  const double size_m = box.size();
  const double half_width = (box.x.plus.reach + box.x.minus.reach) / 2;
  const double half_height = (box.y.plus.reach + box.y.minus.reach) / 2;
  const double half = std::max({half_height, half_width / aspect, kClearance * size_m}) * fit;
  return {{box.x.centre(), box.y.centre(), box.z_max + size_m}, box.z_min, box.z_max, half, size_m};
}

}  // namespace furnace
