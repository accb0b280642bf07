// GGX levels whose kernel is too sharp for the sphere transform.
#pragma once

#include <vector>

#include "renderer/ibl/sphere_transform.hpp"
#include "renderer/ibl/zonal_kernel.hpp"

namespace furnace {

// A level that the sphere transform has already made, on the rows of the result.
struct SmoothLevel {
  GgxKernel kernel;
  RowSpectrum spectrum;
};

// The convolutions of `map` with `kernels`, sharpest first, all narrower than those of `smooth`, as equirects with twice as
// many columns as rows (the derivation stands in the .cpp). The orders of `map` are those of an equirect of its rows.
// Threads: any; the result does not depend on the pool.
std::vector<Image> convolve_sharp(const RowSpectrum& map, const std::vector<GgxKernel>& kernels,
                                  const std::vector<SmoothLevel>& smooth, BakeWork& work);

}  // namespace furnace
