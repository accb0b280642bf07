#include "server/environment_routes.hpp"

#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/image/encode.hpp"
#include "server/negotiation.hpp"

namespace furnace {
namespace {

constexpr std::string_view kFolder = "/v1/environments/";
constexpr std::string_view kExr = ".exr";

// NAME, or NAME and the name of a map: "ggx/3.exr" is "ggx_03".
struct Place {
  std::string name;
  std::string map;
};

std::string map_name(const std::string& path) {
  if (!path.ends_with(kExr))
    fail(ErrorCode::kNotFound,
         "maps are named irradiance.exr, ggx/{i}.exr, charlie/{i}.exr and background.exr");
  const std::string stem = path.substr(0, path.size() - kExr.size());
  if (stem == "background") return "ggx_00";
  const std::size_t slash = stem.find('/');
  if (slash == std::string::npos) return stem;
  const std::string number = stem.substr(slash + 1);
  return fmt::format("{}_{:0>2}", stem.substr(0, slash), number);
}

Place place_of(const Request& request) {
  const std::string rest = request.path.substr(kFolder.size());
  const std::size_t slash = rest.find('/');
  if (slash == std::string::npos) return {rest, {}};
  return {rest.substr(0, slash), map_name(rest.substr(slash + 1))};
}

Reply json(int status, std::string text) {
  return Reply{status, "application/json", std::move(text), {}}.with("Cache-Control", "no-cache");
}

void refuse_map(const Place& place) {
  if (!place.map.empty())
    fail(ErrorCode::kNotFound, "maps are made by the bake: put and delete the environment itself");
}

Reply get(EnvironmentRegistry& registry, const Request& request) {
  const Place place = place_of(request);
  if (place.map.empty()) {
    const api::EnvironmentReport report = registry.report(place.name, request.deadline);
    return json(200, api::environment_report_json(report));
  }
  std::string exr = registry.map_exr(place.name, place.map, request.deadline);
  const std::string etag = hash_bytes(std::as_bytes(std::span(exr))).hex();
  const bool unchanged = etag_matches(request.header("If-None-Match"), etag);
  Reply reply = unchanged ? Reply{304, {}, {}, {}} : Reply{200, "image/x-exr", std::move(exr), {}};
  return reply.with("ETag", '"' + etag + '"').with("Cache-Control", "no-cache");
}

Reply put(EnvironmentRegistry& registry, const Request& request) {
  const Place place = place_of(request);
  refuse_map(place);
  if (request.body.empty()) fail(ErrorCode::kInvalidRequest, "Send the .hdr or .exr file as the body.");
  const EnvironmentRegistry::Put put =
      registry.put(place.name, Blob(std::string(request.body)), request.deadline);
  return json(put.is_new ? 201 : 200, api::environment_report_json(put.report))
      .with("Location", std::string(kFolder) + place.name);
}

Reply erase(EnvironmentRegistry& registry, const Request& request) {
  const Place place = place_of(request);
  refuse_map(place);
  registry.erase(place.name);
  return Reply{204, {}, {}, {}};
}

}  // namespace

std::vector<Route> environment_routes(EnvironmentRegistry& registry) {
  return {
      {"GET", "/v1/environments",
       [&](const Request&) { return json(200, api::environment_names_json(registry.names())); },
       scope::kRender},
      {"GET", "/v1/environments/*", [&](const Request& request) { return get(registry, request); },
       scope::kRender},
      {"PUT", "/v1/environments/*", [&](const Request& request) { return put(registry, request); },
       scope::kAssets},
      {"DELETE", "/v1/environments/*", [&](const Request& request) { return erase(registry, request); },
       scope::kAssets},
  };
}

}  // namespace furnace
