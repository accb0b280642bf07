// What a bake found and made, as JSON: bake.json, and the answer of /v1/environments.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace furnace::api {

struct MapReport {
  std::string name;    // file and address stem
  std::string kernel;  // none, cosine, ggx, charlie
  double perceptual_roughness = 0;
  int width = 0, height = 0;  // px; 0: not said
};

struct SunReport {
  std::array<double, 3> direction{};   // unit, towards the sun
  std::array<double, 3> irradiance{};  // linear Rec. 709, on a plane that faces it
  double angular_radius_degrees = 0;
  double peak = 0;
};

struct EnvironmentReport {
  std::string name;    // as the user calls it
  std::string sha256;  // of the file, hex
  int width = 0, height = 0;
  std::string layout;  // of the file: equirect, horizontal-cross, ...
  double peak = 0;
  std::array<double, 3> mean{};  // solid-angle weighted, linear Rec. 709
  double horizontal_illuminance_lux = 0;
  std::int64_t nan_samples = 0, infinite_samples = 0, negative_samples = 0;
  int bake_version = 0;
  std::string irradiance_method;  // spectral, riemann
  double decode_ms = 0, bake_ms = 0;
  std::string cache;  // hit, miss: whether the bake was there already; empty: not said
  std::vector<SunReport> suns;
  bool suns_extracted = false;  // out of the maps
  std::vector<MapReport> maps;
};

// {"environments": [{"name", "href"}]}
std::string environment_names_json(const std::vector<std::string>& names);
std::string environment_report_json(const EnvironmentReport& report);

}  // namespace furnace::api
