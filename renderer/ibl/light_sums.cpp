#include "renderer/ibl/light_sums.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/ibl/octahedral_atlas.hpp"

namespace furnace {

double ggx_lobe(double cosine, double alpha) {
  // D_GGX(NoH) pi alpha^2, NoH^2 = (1 + cosine) / 2.
  const double a2 = alpha * alpha, d = 0.5 * (1 - cosine) + a2 * 0.5 * (1 + cosine);
  return std::max(cosine, 0.0) * a2 * a2 / (d * d);
}

double ggx_lobe_integral_sr(double alpha) {
  if (alpha >= 1) return std::numbers::pi;
  const double a2 = alpha * alpha, p = 0.5 + 0.5 * a2, q = 0.5 - 0.5 * a2;
  return 2 * std::numbers::pi * a2 * a2 / (q * q) * (p / a2 - 1 + std::log(a2 / p));
}

LightSums light_sums(const std::vector<LightDirection>& lights, int side_px, int levels, WorkerPool& pool) {
  LightSums sums;
  // A lobe's solid angle is some 4 pi alpha^2: it shall hold about 9 directions of an even sky.
  sums.least_alpha = std::clamp(3 / std::sqrt(double(lights.size())), 0.05, 0.5);
  sums.maps = make_image({side_px, side_px * (1 + levels)}, 4, SampleType::kFloat32, ColorSpace::kLinear);
  const auto samples = sums.maps.samples<float>();
  const auto side = std::size_t(side_px);
  std::vector<double> alphas, integrals_sr;
  for (int level = 0; level < levels; ++level) {
    alphas.push_back(std::pow(sums.least_alpha, 1 - double(level) / (levels - 1)));
    integrals_sr.push_back(ggx_lobe_integral_sr(alphas.back()));
  }
  const double row_cost_us = 0.03 * double(side * lights.size() * alphas.size());
  pool.parallel_for(side, row_cost_us, [&](std::size_t y) {
    std::vector<std::array<double, 4>> kernels(1 + alphas.size());
    for (std::size_t x = 0; x < side; ++x) {
      const auto at = direction_from_octahedral(double(x) / double(side - 1), double(y) / double(side - 1));
      std::fill(kernels.begin(), kernels.end(), std::array<double, 4>{});
      for (const LightDirection& light : lights) {
        const auto& d = light.towards;
        const double cosine = at[0] * d[0] + at[1] * d[1] + at[2] * d[2];
        if (cosine <= 0) continue;
        for (std::size_t k = 0; k < kernels.size(); ++k) {
          const double weight = k == 0 ? cosine : ggx_lobe(cosine, alphas[k - 1]) / integrals_sr[k - 1];
          for (std::size_t c = 0; c < 3; ++c) kernels[k][c] += light.irradiance[c] * weight;
          kernels[k][3] += light.solid_angle_sr * weight;
        }
      }
      for (std::size_t k = 0; k < kernels.size(); ++k) {
        for (std::size_t c = 0; c < 4; ++c)
          samples[((k * side + y) * side + x) * 4 + c] = float(kernels[k][c]);
      }
    }
  });
  return sums;
}

}  // namespace furnace
