#include "api/environment_report.hpp"

#include <nlohmann/json.hpp>

namespace furnace::api {
namespace {

using OrderedJson = nlohmann::ordered_json;

// The formulas of ARCHITECTURE.md and of renderer/ibl/zonal_kernel.hpp, for those who score the maps.
const char* kernel_formula(const std::string& kernel) {
  if (kernel == "cosine") return "max(mu, 0) / pi";
  if (kernel == "ggx")
    return "D_GGX(sqrt((1 + mu) / 2)) max(mu, 0), normalised over the sphere; alpha = perceptualRoughness^2";
  if (kernel == "charlie")
    return "D_Charlie(sqrt((1 + mu) / 2)) max(mu, 0), normalised over the sphere; alpha = "
           "perceptualRoughness^2";
  return "the environment itself";
}

OrderedJson map_json(const MapReport& map) {
  OrderedJson json = {{"name", map.name},
                      {"file", map.name + ".exr"},
                      {"kernel", map.kernel},
                      {"formula", kernel_formula(map.kernel)}};
  if (map.kernel == "ggx" || map.kernel == "charlie" || map.kernel == "none")
    json["perceptualRoughness"] = map.perceptual_roughness;
  if (map.width > 0) {
    json["width"] = map.width;
    json["height"] = map.height;
  }
  json["scale"] = 1;
  return json;
}

}  // namespace

namespace {

OrderedJson suns_json(const std::vector<SunReport>& suns) {
  OrderedJson list = OrderedJson::array();
  for (const SunReport& sun : suns) {
    list.push_back({{"direction", sun.direction},
                    {"irradiance", sun.irradiance},
                    {"angularRadiusDegrees", sun.angular_radius_degrees},
                    {"peak", sun.peak}});
  }
  return list;
}

}  // namespace

std::string environment_report_json(const EnvironmentReport& report) {
  OrderedJson maps = OrderedJson::array();
  for (const MapReport& map : report.maps) maps.push_back(map_json(map));
  OrderedJson json = {
      {"name", report.name},
      {"sha256", report.sha256},
      {"width", report.width},
      {"height", report.height},
      {"layout", report.layout},
      {"peak", report.peak},
      {"mean", report.mean},
      {"horizontalIlluminanceLux", report.horizontal_illuminance_lux},
      {"repaired",
       {{"nan", report.nan_samples},
        {"infinite", report.infinite_samples},
        {"negative", report.negative_samples}}},
      {"suns", suns_json(report.suns)},
      {"sunsExtracted", report.suns_extracted},
      {"bakeVersion", report.bake_version},
      {"irradianceMethod", report.irradiance_method},
      {"decodeMs", report.decode_ms},
      {"bakeMs", report.bake_ms},
      {"convention",
       "equirect: row 0 is +Y (up), the centre column looks to +X, u = 0.75 to +Z, u = 0.25 to -Z; "
       "right-handed, +Y up; "
       "u = (column + 0.5) / width"},
      {"units", "linear Rec. 709 radiance of the source times scale; cosine: irradiance / pi"},
      {"maps", maps}};
  if (!report.cache.empty()) json["cache"] = report.cache;
  return json.dump(2) + "\n";
}

std::string environment_names_json(const std::vector<std::string>& names) {
  OrderedJson list = OrderedJson::array();
  for (const std::string& name : names)
    list.push_back(
        {{"name", name}, {"reference", "environment:" + name}, {"href", "/v1/environments/" + name}});
  return OrderedJson({{"environments", list}}).dump(2) + "\n";
}

}  // namespace furnace::api
