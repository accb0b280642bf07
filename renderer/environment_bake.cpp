#include "renderer/environment_bake.hpp"

#include <chrono>

#include <fmt/format.h>

#include "renderer/ibl/riemann.hpp"

namespace furnace {
namespace {

constexpr Extent kRiemannQuads{256, 128};
constexpr int kRiemannRows = 64;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

std::vector<EnvironmentMap> EnvironmentBake::list() const {
  std::vector<EnvironmentMap> all;
  const bool riemann = !riemann_irradiance.pixels.empty();
  all.push_back({"irradiance", "cosine", 1, riemann ? &riemann_irradiance : &maps->irradiance});
  all.push_back({"ggx_00", "none", 0, maps->radiance.get()});
  for (std::size_t i = 0; i < maps->levels.size(); ++i) {
    const BakedLevel& level = maps->levels[i];
    all.push_back({fmt::format("ggx_{:02}", i + 1), "ggx", level.perceptual_roughness, &level.equirect});
  }
  for (std::size_t i = 0; i < maps->charlie.size(); ++i) {
    const BakedLevel& level = maps->charlie[i];
    all.push_back({fmt::format("charlie_{:02}", i), "charlie", level.perceptual_roughness, &level.equirect});
  }
  return all;
}

EnvironmentBake bake_whole_environment(const Blob& encoded, const EnvironmentBakeSettings& settings,
                                       WorkerPool& pool, Decoder& decoder, const Deadline& deadline) {
  EnvironmentBake bake;
  const Clock::time_point decode_start = Clock::now();
  DecodedEnvironment decoded = decoder.environment(encoded, settings.layout, settings.limits, deadline);
  bake.decode_ms = ms_since(decode_start);
  bake.repairs = decoded.repairs;
  bake.layout = decoded.layout;
  bake.size = decoded.equirect.extent;
  const Clock::time_point bake_start = Clock::now();
  bake.suns_extracted = settings.sun == SunMode::kExtract;
  if (bake.suns_extracted) {
    SunExtraction extraction = extract_suns(decoded.equirect, deadline);
    bake.suns = std::move(extraction.suns);
    decoded.equirect = std::move(extraction.residual);
  } else {
    bake.suns = find_suns(decoded.equirect, deadline);
  }
  const auto radiance = std::make_shared<const Image>(std::move(decoded.equirect));
  bake.maps = bake_environment(radiance, encoded.hash(), pool, deadline,
                               BakeSettings{.charlie = true, .progress = settings.progress});
  if (settings.irradiance == IrradianceMethod::kRiemann)
    bake.riemann_irradiance = riemann_irradiance(*radiance, kRiemannQuads, kRiemannRows, pool, deadline);
  bake.bake_ms = ms_since(bake_start);
  return bake;
}

}  // namespace furnace
