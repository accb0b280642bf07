// All prefiltered levels and the irradiance of one environment in one 2D texture of octahedral tiles: one fetch class for
// the shader, any size per level, no seams (each tile carries a one-texel border that continues the sphere).
#pragma once

#include <vector>

#include "renderer/ibl/baked_environment.hpp"

namespace furnace {

// A square tile; `inner` texels without the border start at (x, y).
struct AtlasTile {
  int x = 0;      // px, left inner texel
  int y = 0;      // px, top inner texel
  int inner = 0;  // px, side without the border
};

// Threads: a value. Owns: its pixels.
struct OctahedralAtlas {
  Image texels;      // RGBA kFloat16, alpha 1: stored = radiance * scale
  double scale = 1;  // power of two such that the peak of all tiles fits a half float; shader divides
  std::vector<double> level_roughness;  // of tiles[i], from the first level above 0 up to 1
  std::vector<AtlasTile> level_tiles;
  AtlasTile irradiance_tile;
};

// Unit direction (world, +Y up) -> octahedral coordinates in [0,1]^2, and back (Cigolle et al. 2014, "A Survey of Efficient
// Representations for Independent Unit Vectors"): o = d / (|x|+|y|+|z|), folded over the -Y half;
// u from x, v from z. The same lines stand in shaders/lib/sphere.glsl.
struct OctahedralUv {
  double u = 0;
  double v = 0;
};
OctahedralUv octahedral_from_direction(double x, double y, double z);
std::array<double, 3> direction_from_octahedral(double u, double v);

// Resamples (by an interpolation that keeps the levels' bar) on the pool. Threads: any.
OctahedralAtlas make_octahedral_atlas(const BakedEnvironment& baked, WorkerPool& pool);

}  // namespace furnace
