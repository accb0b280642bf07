#include "server/environment_report.hpp"

#include <numbers>

#include <fmt/format.h>

namespace furnace {
namespace {

void add_repairs(const RepairReport& repairs, api::EnvironmentReport& report) {
  report.nan_samples = repairs.nan_samples;
  report.infinite_samples = repairs.infinite_samples;
  report.negative_samples = repairs.negative_samples;
}

void add_suns(const std::vector<Sun>& suns, api::EnvironmentReport& report) {
  for (const Sun& sun : suns) {
    report.suns.push_back(
        {sun.direction, sun.irradiance, sun.angular_radius_rad * 180 / std::numbers::pi, sun.peak});
  }
}

void add_levels(const std::string& kernel, const std::vector<double>& roughness,
                api::EnvironmentReport& report) {
  for (std::size_t i = 0; i < roughness.size(); ++i)
    report.maps.push_back(
        {fmt::format("{}_{:02}", kernel, i), roughness[i] > 0 ? kernel : "none", roughness[i]});
}

}  // namespace

api::EnvironmentReport report_of(const std::string& name, const Blob& encoded,
                                 const EnvironmentSummary& summary, bool was_cached) {
  api::EnvironmentReport report;
  report.name = name;
  report.sha256 = encoded.hash().hex();
  report.width = summary.size.width;
  report.height = summary.size.height;
  report.layout = name_of(summary.layout);
  report.peak = summary.peak;
  report.mean = summary.mean;
  report.horizontal_illuminance_lux = summary.horizontal_illuminance_lux;
  add_repairs(summary.repairs, report);
  add_suns(summary.suns, report);
  report.bake_version = kBakeVersion;
  report.irradiance_method = "spectral";
  report.bake_ms = summary.bake_ms;
  report.cache = was_cached ? "hit" : "miss";
  report.maps.push_back({"irradiance", "cosine", 1});
  add_levels("ggx", ggx_level_roughness(), report);
  add_levels("charlie", charlie_level_roughness(), report);
  return report;
}

api::EnvironmentReport report_of(const std::string& name, const Blob& encoded, const EnvironmentBake& bake) {
  api::EnvironmentReport report;
  report.name = name;
  report.sha256 = encoded.hash().hex();
  report.width = bake.size.width;
  report.height = bake.size.height;
  report.layout = name_of(bake.layout);
  report.peak = bake.maps->peak;
  report.mean = bake.maps->mean;
  report.horizontal_illuminance_lux = horizontal_illuminance_lux(*bake.maps);
  add_repairs(bake.repairs, report);
  add_suns(bake.suns, report);
  report.suns_extracted = bake.suns_extracted;
  report.bake_version = kBakeVersion;
  report.irradiance_method = bake.riemann_irradiance.pixels.empty() ? "spectral" : "riemann";
  report.decode_ms = bake.decode_ms;
  report.bake_ms = bake.bake_ms;
  for (const EnvironmentMap& map : bake.list()) {
    report.maps.push_back({map.name, map.kernel, map.perceptual_roughness, map.equirect->extent.width,
                           map.equirect->extent.height});
  }
  return report;
}

}  // namespace furnace
