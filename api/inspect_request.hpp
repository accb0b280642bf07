// The document of POST /v1/inspect.
#pragma once

#include <memory>
#include <string_view>

#include "api/render_request.hpp"
#include "renderer/assets/asset_resolver.hpp"

namespace furnace::api {

struct InspectRequest {
  std::shared_ptr<const ModelBundle> model;
  ImportOptions options;
};

// Errors: as parse_render_request.
InspectRequest parse_inspect_request(std::string_view json, const AssetResolver& assets,
                                     const RequestLimits& limits);

}  // namespace furnace::api
