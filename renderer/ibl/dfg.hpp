// Directional albedo of the GGX lobe, by quadrature; depends on no environment, computed once per process.
#pragma once

#include <vector>

namespace furnace {

// Table over (NoV, perceptual roughness), each axis sampled at texel centres (i + 0.5) / size; row = roughness, column = NoV.
// Directional albedo for Schlick Fresnel: E(F0) = F0 * scale + bias  (Karis 2013, "Real Shading in Unreal Engine 4"),
// with D = GGX and V = height-correlated Smith (Heitz 2014), so E(1) = scale + bias.
struct DfgTexel {
  float scale = 0;
  float bias = 0;
  float lean_rad = 0;  // angle from the mirror direction r to the first moment of f (n.l) for F = 1, in the plane of n and
                       // v, positive towards n
  float spread = 0;    // length of that first moment / E(1), in [0, 1]: 1 = all in one direction
};

struct DfgTable {
  int size = 0;
  std::vector<DfgTexel> texels;  // size * size
};

// Absolute error <= 1e-4 in scale and bias at every texel. Threads: any; deterministic.
DfgTable compute_dfg_table(int size);

}  // namespace furnace
