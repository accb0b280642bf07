// Directional albedo of the GGX lobe, by quadrature; depends on no environment.
#pragma once

#include <span>
#include <vector>

namespace furnace {

// Table over (NoV, perceptual roughness), each axis sampled at texel centres (i + 0.5) / size; row = roughness, column = NoV.
// Directional albedo for Schlick Fresnel: E(F0) = F0 * scale + bias  (Karis 2013, "Real Shading in Unreal Engine 4"),
// with D = GGX and V = height-correlated Smith (Heitz 2014), so E(1) = scale + bias.
//
// The first moment of f (n.l) (F = 1) over l is the mean direction of the lobe. It lies in the plane of n and v, and for a
// rough surface nearer to n than the mirror direction r = 2 (n.v) n - v is: the map is looked up there instead of at r.
//   mean direction = r rotated by lean_rad towards n = cos(a) n + sin(a) t,  a = acos(n.v) - lean_rad,
//   t = (r - (n.v) n) / sin(acos(n.v)), the unit tangent that r leans to.
struct DfgTexel {
  float scale = 0;
  float bias = 0;
  float lean_rad = 0;  // from r towards n
  float sheen = 0;     // sheen_albedo()
};

struct DfgTable {
  int size = 0;
  std::vector<DfgTexel> texels;  // size * size
};

// The table that the shaders read, kDfgTableSize on a side: worked out when the program is built (make_lobe_tables.cpp).
inline constexpr int kDfgTableSize = 128;
std::span<const DfgTexel> dfg_table();

// Absolute error <= 1e-4 in scale and bias at every texel. Threads: any; deterministic.
DfgTable compute_dfg_table(int size);

}  // namespace furnace
