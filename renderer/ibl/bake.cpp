// Every map of an environment is its convolution with a zonal kernel. In spherical harmonics that is a product (the
// Funk-Hecke theorem; Driscoll and Healy 1994, "Computing Fourier Transforms and Convolutions on the 2-Sphere"):
//
//   | b_lm = k_l a_lm,  k_l = 2 pi * integral of K(mu) P_l(mu) dmu |
//
// so one analysis serves all maps, and each is synthesised on the coarsest grid that holds it.
#include "renderer/ibl/baked_environment.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/sharp_level.hpp"
#include "renderer/ibl/sphere_transform.hpp"
#include "renderer/ibl/zonal_kernel.hpp"

namespace furnace {

namespace {

// Below this roughness a level is made by convolve_sharp: 512 degrees would not do.
constexpr double kSharpBelow = 0.125;
constexpr std::size_t kSmoothLevels = 3;  // the first ones above it carry the tails of the sharp ones
constexpr int kBands = 512;
constexpr int kFewestRows = 512;  // of the working map
constexpr int kCharlieRows = 192;
constexpr double kCutOff = 3e-5;            // sufficient_bands of a level,
constexpr double kIrradianceCutOff = 2e-5;  // and of the irradiance

// A map of few texels, each cut into equal ones: the same piecewise constant function on a finer grid.
std::shared_ptr<const Image> working_map(std::shared_ptr<const Image> map) {
  const auto [width, height] = map->extent;
  const int factor = (kFewestRows + height - 1) / height;
  if (factor <= 1) return map;
  auto fine = std::make_shared<Image>(
      make_image({width * factor, height * factor}, 3, SampleType::kFloat32, ColorSpace::kLinear));
  const float* in = map->samples<float>().data();
  float* out = fine->samples<float>().data();
  for (int j = 0; j < height * factor; ++j) {
    for (int i = 0; i < width * factor; ++i) {
      const float* texel = in + (std::size_t(j / factor) * width + i / factor) * 3;
      out = std::copy(texel, texel + 3, out);
    }
  }
  return fine;
}

// Rows of a grid that bicubic reading follows: so many to a kernel's width, and enough for its kink at the horizon.
int level_rows(double alpha, int map_rows) {
  const double wanted = std::max(12 / alpha, 128.0);
  for (int rows : {128, 144, 192, 256, 288, 384, 512})
    if (rows >= wanted) return std::min(rows, map_rows);
  return map_rows;
}

std::vector<double> level_coefficients(double alpha, double cut_off) {
  std::vector<double> k = zonal_coefficients(GgxKernel(alpha), alpha, kBands);
  k.resize(sufficient_bands(k, cut_off));
  return k;
}

// Wide, but with a kink at the horizon that is the sharper the lower the roughness.
std::vector<double> charlie_coefficients(double alpha) {
  std::vector<double> k = zonal_coefficients(CharlieKernel(alpha), std::numbers::pi, kBands);
  k.resize(sufficient_bands(k, kCutOff));
  return k;
}

std::array<double, 3> mean_radiance(const HarmonicCoefficients& coefficients) {
  const Lanes a00 = coefficients.order(0)[0];
  const double scale = 1 / std::sqrt(4 * std::numbers::pi);
  return {scale * a00[0], scale * a00[2], scale * a00[4]};
}

}  // namespace

std::shared_ptr<const BakedEnvironment> bake_environment(std::shared_ptr<const Image> radiance,
                                                         const ContentHash& source_hash, WorkerPool& pool,
                                                         const Deadline& deadline,
                                                         const BakeSettings& settings) {
  const auto start = Clock::now();
  auto baked = std::make_shared<BakedEnvironment>();
  baked->source_hash = source_hash;
  baked->radiance = radiance;
  const auto samples = radiance->samples<float>();
  baked->peak = *std::max_element(samples.begin(), samples.end());
  const std::vector<double> roughness = ggx_level_roughness();
  for (std::size_t i = 1; i < roughness.size(); ++i) baked->levels.push_back({roughness[i], {}});

  check_deadline(deadline, "environment: rows");
  const std::shared_ptr<const Image> map = working_map(radiance);
  const int map_rows = map->extent.height;
  const RowSpectrum spectrum = spectrum_of_equirect(*map, pool);

  check_deadline(deadline, "environment: analysis");
  const LegendreTable table(kBands);
  const HarmonicCoefficients coefficients = analyse(spectrum, table, pool);
  baked->mean = mean_radiance(coefficients);

  std::vector<GgxKernel> sharp_kernels;
  std::vector<SmoothLevel> smooth;
  for (BakedLevel& level : baked->levels) {
    const double alpha = level.perceptual_roughness * level.perceptual_roughness;
    if (level.perceptual_roughness < kSharpBelow) {
      sharp_kernels.emplace_back(alpha);
      continue;
    }
    check_deadline(deadline, "environment: rough level");
    const bool shared = smooth.size() < kSmoothLevels;
    const int rows = shared ? map_rows : level_rows(alpha, map_rows);
    RowSpectrum level_spectrum = synthesise(
        coefficients, table, level_coefficients(alpha, alpha == 1 ? kIrradianceCutOff : kCutOff), rows, pool);
    level.equirect = equirect_of_spectrum(level_spectrum, 2 * rows, pool);
    if (shared) smooth.push_back({GgxKernel(alpha), std::move(level_spectrum)});
  }
  baked->irradiance = baked->levels.back().equirect;  // at alpha = 1 GGX is Lambert's cosine

  if (settings.charlie) {
    for (const double roughness : charlie_level_roughness()) {
      check_deadline(deadline, "environment: sheen level");
      const std::vector<double> k = charlie_coefficients(roughness * roughness);
      const int rows = std::min(kCharlieRows, map_rows);
      const RowSpectrum level = synthesise(coefficients, table, k, rows, pool);
      baked->charlie.push_back({roughness, equirect_of_spectrum(level, 2 * rows, pool)});
    }
  }

  check_deadline(deadline, "environment: sharp levels");
  std::vector<Image> sharp = convolve_sharp(spectrum, sharp_kernels, smooth, pool);
  for (std::size_t i = 0; i < sharp.size(); ++i) baked->levels[i].equirect = std::move(sharp[i]);
  baked->bake_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  return baked;
}

}  // namespace furnace
