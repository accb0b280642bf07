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

#include "renderer/ibl/alike_levels.hpp"
#include "renderer/ibl/sharp_level.hpp"
#include "renderer/ibl/sphere_transform.hpp"
#include "renderer/ibl/zonal_kernel.hpp"

namespace furnace {

namespace {

// Below this roughness a level is made by convolve_sharp: 512 degrees would not do.
constexpr double kSharpBelow = 0.125;
constexpr std::size_t kSmoothLevels = 3;  // the first ones above it carry the tails of the sharp ones
constexpr int kBands = 512;
constexpr int kFewestRows = 512;            // of the working map
constexpr int kMostRows = 1024;             // of a level: what the largest tile of the atlas can show
constexpr int kRoughRows = 192;             // of levels that are as wide as the hemisphere
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
  const double wanted = std::max<double>(12 / alpha, kRoughRows);
  for (int rows : {kRoughRows, 256, 288, 384, 512})
    if (rows >= wanted) return std::min(rows, map_rows);
  return std::min(map_rows, kMostRows);
}

std::vector<double> ggx_coefficients(double alpha) {
  return zonal_coefficients(GgxKernel(alpha), alpha, kBands);
}

// Wide, but with a kink at the horizon that is the sharper the lower the roughness.
std::vector<double> charlie_coefficients(double alpha) {
  return zonal_coefficients(CharlieKernel(alpha), std::numbers::pi, kBands);
}

std::array<double, 3> mean_radiance(const HarmonicCoefficients& coefficients) {
  const Lanes a00 = coefficients.order(0)[0];
  const double scale = 1 / std::sqrt(4 * std::numbers::pi);
  return {scale * a00[0], scale * a00[2], scale * a00[4]};
}

// CPU milliseconds as measured once: they only say how far a bake has come.
struct StageCosts {
  static constexpr double kCharlie = 3, kWhole = 6;

  StageCosts(int map_rows, int most_rows, const BakeSettings& settings)
      : rows(2.2e-5 * map_rows * map_rows),
        analysis(12 + 0.02 * map_rows),
        shared_level(8 + 2.6e-5 * most_rows * most_rows),
        sharp(15 + 1e-4 * map_rows * most_rows) {
    for (double roughness : ggx_level_roughness())
      if (roughness >= kSharpBelow) all += level(roughness * roughness);
    all += rows + analysis + kWhole + sharp;
    if (settings.charlie) all += kCharlie * double(charlie_level_roughness().size());
  }

  double level(double alpha) const { return alpha < 0.035 ? shared_level : 0.08 / alpha; }
  double share(double cost) const { return cost / all; }

  double rows = 0, analysis = 0, shared_level = 0, sharp = 0, all = 0;
};

double alpha_of(const BakedLevel& level) {
  return level.perceptual_roughness * level.perceptual_roughness;
}

bool is_sharp(const BakedLevel& level) {
  return level.perceptual_roughness < kSharpBelow;
}

// One bake: what its steps have in common.
struct Bake {
  BakedEnvironment& baked;
  int map_rows, most_rows;
  StageCosts costs;
  BakeWork& work;
};

RowSpectrum synthesise_level(const Bake& bake, const HarmonicCoefficients& coefficients,
                             const LegendreTable& table, BakedLevel& level, int rows) {
  std::vector<double> k = ggx_coefficients(alpha_of(level));
  k.resize(sufficient_bands(k, kCutOff));
  RowSpectrum spectrum = synthesise(coefficients, table, k, rows, bake.work);
  level.equirect = equirect_of_spectrum(spectrum, 2 * rows, bake.work);
  return spectrum;
}

// The sharp levels and those that carry their tails. They need most of the memory, so they come first and alone.
void bake_sharp_levels(const Bake& bake, RowSpectrum map, const HarmonicCoefficients& coefficients,
                       const LegendreTable& table) {
  std::vector<BakedLevel>& levels = bake.baked.levels;
  std::vector<GgxKernel> kernels;
  for (const BakedLevel& level : levels)
    if (is_sharp(level)) kernels.emplace_back(alpha_of(level));
  std::vector<SmoothLevel> smooth;
  for (std::size_t i = kernels.size(); i < kernels.size() + kSmoothLevels; ++i) {
    const double alpha = alpha_of(levels[i]);
    bake.work.begin("environment: rough level", bake.costs.share(bake.costs.level(alpha)));
    smooth.push_back(
        {GgxKernel(alpha), synthesise_level(bake, coefficients, table, levels[i], bake.most_rows)});
  }
  bake.work.begin("environment: sharp levels", bake.costs.share(bake.costs.sharp));
  std::vector<Image> sharp = convolve_sharp(map, kernels, smooth, bake.work);
  for (std::size_t i = 0; i < sharp.size(); ++i) levels[i].equirect = std::move(sharp[i]);
}

void bake_rough_levels(const Bake& bake, const HarmonicCoefficients& coefficients, const LegendreTable& table,
                       bool charlie) {
  AlikeLevels wide(coefficients, table, std::min(kRoughRows, bake.map_rows));
  bake.work.begin("environment: irradiance", bake.costs.share(StageCosts::kWhole));
  bake.baked.irradiance = wide.level(ggx_coefficients(1), kIrradianceCutOff, bake.work);
  bake.baked.levels.back().equirect = bake.baked.irradiance;  // at alpha = 1 GGX is Lambert's cosine
  for (BakedLevel& level : bake.baked.levels) {
    if (!level.equirect.pixels.empty()) continue;
    const double alpha = alpha_of(level);
    const int rows = level_rows(alpha, bake.map_rows);
    bake.work.begin("environment: rough level", bake.costs.share(bake.costs.level(alpha)));
    if (rows == wide.rows())
      level.equirect = wide.level(ggx_coefficients(alpha), kCutOff, bake.work);
    else
      synthesise_level(bake, coefficients, table, level, rows);
  }
  if (!charlie) return;
  for (const double roughness : charlie_level_roughness()) {
    bake.work.begin("environment: sheen level", bake.costs.share(StageCosts::kCharlie));
    bake.baked.charlie.push_back(
        {roughness, wide.level(charlie_coefficients(roughness * roughness), kCutOff, bake.work)});
  }
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
  baked->peak = largest_sample(radiance->samples<float>());
  const std::vector<double> roughness = ggx_level_roughness();
  for (std::size_t i = 1; i < roughness.size(); ++i) baked->levels.push_back({roughness[i], {}});

  std::shared_ptr<const Image> map = working_map(std::move(radiance));
  const int map_rows = map->extent.height, most_rows = std::min(map_rows, kMostRows);
  BakeWork work(pool, deadline, settings.progress);
  const Bake bake{*baked, map_rows, most_rows, StageCosts(map_rows, most_rows, settings), work};
  work.begin("environment: rows", bake.costs.share(bake.costs.rows));
  RowSpectrum spectrum = spectrum_of_equirect(*map, work);
  map.reset();

  work.begin("environment: analysis", bake.costs.share(bake.costs.analysis));
  const LegendreTable table(kBands);
  const HarmonicCoefficients coefficients = analyse(spectrum, table, work);
  baked->mean = mean_radiance(coefficients);

  bake_sharp_levels(bake, std::move(spectrum), coefficients, table);
  bake_rough_levels(bake, coefficients, table, settings.charlie);
  work.finish();
  baked->bake_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  return baked;
}

}  // namespace furnace
