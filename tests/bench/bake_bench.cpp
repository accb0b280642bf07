// The bake of every HDRI in ../shared/data/environments: time, memory, and errors against sums in double precision.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "renderer/base/file.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/baked_environment.hpp"
#include "renderer/ibl/blur.hpp"
#include "renderer/ibl/octahedral_atlas.hpp"
#include "renderer/ibl/suns.hpp"
#include "renderer/image/decode.hpp"
#include "tests/bench/bench_main.hpp"
#include "tests/support/reference/convolution.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using reference::Direction;
using reference::Rgb;

const fs::path kData = fs::path(FURNACE_SOURCE_DIR) / ".." / "shared" / "data" / "environments";
constexpr int kDirections =
    24;  // of each comparison: a sum over half a million texels costs a quarter of a second

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * double(sysconf(_SC_PAGESIZE)) / 1e6;
}

// Since the last call of forget_peak().
double peak_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1e3;
  }
  return 0;
}

void forget_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

struct Errors {
  double sharp = 0, smooth = 0, between_sharp = 0, between = 0, irradiance = 0, energy = 0, lowest = 0;
};

void compare_levels(const BakedEnvironment& baked, Errors& errors) {
  const Rgb mean = reference::mean_radiance(*baked.radiance);
  for (std::size_t l = 0; l < baked.levels.size(); ++l) {
    const BakedLevel& level = baked.levels[l];
    const reference::Prefilter one(*baked.radiance,
                                   {level.perceptual_roughness * level.perceptual_roughness});
    std::vector<Rgb> computed, expected;
    for (const Direction& d : reference::spread_directions(kDirections)) {
      const Extent size = level.equirect.extent;
      const int i = std::clamp(int((d.phi / (2 * std::numbers::pi) + 0.5) * size.width), 0, size.width - 1);
      const int j = std::clamp(int(d.theta / std::numbers::pi * size.height), 0, size.height - 1);
      computed.push_back(reference::texel_value(level.equirect, i, j));
      expected.push_back(one(reference::texel_direction(size, i, j))[0]);
    }
    double& worst = level.perceptual_roughness < 0.125 ? errors.sharp : errors.smooth;
    worst = std::max(worst, reference::relative_rmse(computed, expected));
    const Rgb level_mean = reference::mean_radiance(level.equirect);
    const auto samples = level.equirect.samples<float>();
    for (int c = 0; c < 3; ++c)
      errors.energy = std::max(errors.energy, std::abs(level_mean[c] / mean[c] - 1));
    errors.lowest =
        std::min(errors.lowest, double(*std::min_element(samples.begin(), samples.end())) / mean[1]);
    if (l + 1 == baked.levels.size()) errors.irradiance = reference::relative_rmse(computed, expected);
  }
}

void compare_between(const BakedEnvironment& baked, const OctahedralAtlas& atlas, Errors& errors) {
  const std::vector<double> levels = ggx_level_roughness();
  std::vector<double> roughness, alphas;
  for (std::size_t i = 2; i < levels.size(); ++i) {
    roughness.push_back(0.5 * (levels[i - 1] + levels[i]));
    alphas.push_back(roughness.back() * roughness.back());
  }
  const reference::Prefilter judge(*baked.radiance, alphas);
  std::vector<std::vector<Rgb>> computed(alphas.size()), expected(alphas.size());
  for (const Direction& d : reference::spread_directions(kDirections)) {
    const std::vector<Rgb> sums = judge(d);
    for (std::size_t k = 0; k < alphas.size(); ++k) {
      computed[k].push_back(reference::read_levels(baked, atlas, roughness[k], d));
      expected[k].push_back(sums[k]);
    }
  }
  for (std::size_t k = 0; k < alphas.size(); ++k) {
    double& worst = roughness[k] < 0.15 ? errors.between_sharp : errors.between;
    worst = std::max(worst, reference::relative_rmse(computed[k], expected[k]));
  }
}

// The CPU seconds of the best of `times`.
template <class Body>
double best_cpu_s(int times, Body&& body) {
  double best = 1e9;
  for (int i = 0; i < times; ++i) {
    const double start = cpu_s();
    body();
    best = std::min(best, cpu_s() - start);
  }
  return best;
}

Json bench_map(const std::string& name, std::shared_ptr<const Image> radiance, bool judge) {
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  WorkerPool pool(static_cast<int>(cores));
  const int times = radiance->extent.width > 4096 ? 1 : 5;
  std::shared_ptr<const BakedEnvironment> baked;
  const double before_mb = resident_mb();
  forget_peak();
  const double cpu = best_cpu_s(times, [&] {
    baked.reset();
    baked = bake_environment(radiance, {}, pool, {});
  });
  const double peak = peak_mb() - before_mb;
  OctahedralAtlas atlas;
  const double atlas_cpu = best_cpu_s(times, [&] {
    atlas = {};
    atlas = make_octahedral_atlas(*baked, pool);
  });
  const double blur_cpu =
      best_cpu_s(times, [&] { blurred_environment(*radiance, 8 * std::numbers::pi / 180, pool, {}); });
  const double suns_cpu = best_cpu_s(times, [&] { find_suns(*radiance, {}); });
  Json row = {{"name", name},
              {"width", radiance->extent.width},
              {"height", radiance->extent.height},
              {"peak", baked->peak},
              {"bakeCpuSeconds", cpu},
              {"bakeWallMs", baked->bake_ms},
              {"atlasCpuSeconds", atlas_cpu},
              {"blurCpuSeconds", blur_cpu},
              {"sunsCpuSeconds", suns_cpu},
              {"peakMb", peak}};
  fmt::print("{:<36}{:>5}x{:<5}{:>10.0f}{:>9.3f}{:>8.0f}{:>9.3f}{:>8.3f}{:>8.3f}{:>8.0f}", name,
             radiance->extent.width, radiance->extent.height, baked->peak, cpu, baked->bake_ms, atlas_cpu,
             blur_cpu, suns_cpu, peak);
  if (judge) {
    Errors errors;
    compare_levels(*baked, errors);
    compare_between(*baked, atlas, errors);
    row["errors"] = {{"levelsBelow0.125", errors.sharp},
                     {"levels", errors.smooth},
                     {"between0.05And0.15", errors.between_sharp},
                     {"between", errors.between},
                     {"irradiance", errors.irradiance},
                     {"energy", errors.energy},
                     {"lowest", errors.lowest}};
    fmt::print("{:>10.1e}{:>10.1e}{:>10.1e}{:>10.1e}{:>10.1e}{:>10.1e}{:>10.1e}", errors.sharp, errors.smooth,
               errors.between_sharp, errors.between, errors.irradiance, errors.energy, errors.lowest);
  }
  fmt::print("\n");
  std::fflush(stdout);
  return row;
}

// Each texel varied, so that the finer map has detail of its own.
Image enlarged(const Image& map, int factor) {
  const Extent size{map.extent.width * factor, map.extent.height * factor};
  Image fine = make_image(size, 3, SampleType::kFloat32, ColorSpace::kLinear);
  float* out = fine.samples<float>().data();
  std::uint32_t state = 1;
  for (int j = 0; j < size.height; ++j) {
    for (int i = 0; i < size.width; ++i) {
      state = state * 1664525u + 1013904223u;
      const double vary = 0.5 + double(state >> 8) / double(1 << 24);
      for (double value : reference::texel_value(map, i / factor, j / factor))
        *out++ = static_cast<float>(vary * value);
    }
  }
  return fine;
}

Json run(const std::string&) {
  if (!fs::exists(kData)) {
    fmt::print("there is no {}: nothing to bake\n", kData.string());
    return Json::array();
  }
  // FURNACE_BENCH_JUDGE=0 leaves the errors out: they take minutes. FURNACE_BENCH_MAP=NAME bakes one,
  // FURNACE_BENCH_LARGE=0 leaves out what is enlarged from it.
  const char *choice = std::getenv("FURNACE_BENCH_JUDGE"), *only = std::getenv("FURNACE_BENCH_MAP"),
             *large = std::getenv("FURNACE_BENCH_LARGE");
  const bool judge = choice == nullptr || std::string(choice) != "0";
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(kData)) {
    const fs::path& path = entry.path();
    if (only != nullptr && path.stem() != only) continue;
    if (path.extension() == ".hdr" || path.extension() == ".exr") paths.push_back(path);
  }
  std::sort(paths.begin(), paths.end());
  fmt::print("{:<36}{:>11}{:>10}{:>9}{:>8}{:>9}{:>8}{:>8}{:>8}", "environment", "px", "peak", "CPU s",
             "wall ms", "atlas s", "blur s", "suns s", "MB");
  if (judge)
    fmt::print("{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}", "r<.125", "levels", "btw<.15", "between",
               "irrad.", "energy", "lowest");
  fmt::print(
      "\nbars: 0.2 CPU s and 100 MB at 1024x512, 1 and 400 at 4096x2048; errors 1e-2, 1e-3, 3e-2, 1e-2, "
      "1e-4, "
      "1e-3, -1e-4\n");
  Json rows = Json::array();
  for (const fs::path& path : paths) {
    const Blob file(read_file(path, 1ll << 30));
    const auto map = std::make_shared<const Image>(decode_environment(file, {}).equirect);
    rows.push_back(bench_map(path.stem().string(), map, judge));
    if (&path != &paths.back() || (large != nullptr && std::string(large) == "0")) continue;
    for (int width : {4096, 8192}) {
      const int factor = width / map->extent.width;
      const std::string name = fmt::format("{}, {} times", path.stem().string(), factor);
      rows.push_back(bench_map(name, std::make_shared<Image>(enlarged(*map, factor)), false));
    }
  }
  return rows;
}

}  // namespace
}  // namespace furnace

int main(int argc, char** argv) {
  return furnace::bench_main(argc, argv, furnace::run);
}
