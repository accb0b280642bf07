// The GGX lobe as a linearly transformed cosine, for lights that are polygons; depends on no light.
#pragma once

#include <span>
#include <vector>

namespace furnace {

// Heitz, Dupuy, Hill and Neubelt 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines".
// In the frame (x, y, n) with the viewer at (sin, 0, cos) of its angle, D V (n.l) divided by its own integral is nearly the
// clamped cosine lobe cos / pi of the direction
//   | a  0  b |
//   | 0  1  0 | l,   alpha = roughness^2, at least kLtcMinAlpha.
//   | c alpha  0  d alpha |
// Divided so, every entry changes smoothly down to the mirror.
struct LtcTexel {
  float a = 1, b = 0;
  float c = 0, d = 1;
};

inline constexpr double kLtcMinAlpha = 1e-3;

// As large as the DFG table, over (sqrt(1 - n.v), perceptual roughness) at texel centres; row = roughness. Worked out when the
// program is built (make_lobe_tables.cpp).
std::span<const LtcTexel> ltc_table();

// Fitted at (fits + 1)^2 places, linear between. Half the difference between the lobe and its fit, integrated, is 0.04 in the
// mean, and more near grazing angles. Threads: any; deterministic.
std::vector<LtcTexel> compute_ltc_table(int size, int fits);

// The density of the fitted lobe towards unit `l` (its x, y, z).
double ltc_density(const LtcTexel& texel, double alpha, double x, double y, double z);

}  // namespace furnace
