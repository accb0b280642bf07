#include "renderer/ibl/alike_levels.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/zonal_kernel.hpp"

namespace furnace {
namespace {

constexpr int kBands = 512, kRows = 192;

// A sun and nothing else: the hardest map for kernels that end at the horizon.
Image lone_sun() {
  Image map = make_image({1024, 512}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (int c = 0; c < 3; ++c) map.samples<float>()[(120 * 1024 + 300) * 3 + c] = 1e5f * float(c + 1);
  return map;
}

double rms_difference(const Image& a, const Image& b) {
  double sum = 0;
  const auto x = a.samples<float>(), y = b.samples<float>();
  for (std::size_t k = 0; k < x.size(); ++k) sum += std::pow(double{x[k]} - y[k], 2);
  return std::sqrt(sum / double(x.size()));
}

// Levels in the order of a bake: those that come first serve the later ones.
TEST(AlikeLevels, AreWhatAllDegreesGive) {
  WorkerPool pool(2);
  BakeWork work(pool);
  const LegendreTable table(kBands);
  const HarmonicCoefficients sun = analyse(spectrum_of_equirect(lone_sun(), work), table, work);
  const double mean = 2 * sun.values[0][0] / std::sqrt(4 * std::numbers::pi);  // of the colours' middle one
  AlikeLevels alike(sun, table, kRows);
  const auto compare = [&](const std::vector<double>& kernel) {
    const Image all = equirect_of_spectrum(synthesise(sun, table, kernel, kRows, work), 2 * kRows, work);
    // Of the cut's order, for light from one direction.
    EXPECT_LT(rms_difference(alike.level(kernel, 3e-5, work), all), 1e-4 * mean);
  };
  for (double alpha : {1.0, 0.1, 0.3, 0.6}) {
    SCOPED_TRACE(alpha);
    compare(zonal_coefficients(GgxKernel(alpha), alpha, kBands));
  }
  for (double alpha : {0.01, 0.0225, 0.04, 0.09, 0.3, 1.0}) {
    SCOPED_TRACE(alpha);
    compare(zonal_coefficients(CharlieKernel(alpha), std::numbers::pi, kBands));
  }
}

}  // namespace
}  // namespace furnace
