// The routes below /v1/assets, and what requests may refer to.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "renderer/assets/asset_resolver.hpp"
#include "server/dispatcher.hpp"
#include "server/routes.hpp"

namespace furnace {

// None where Doors::assets is null.
std::vector<Route> asset_routes(const Doors& doors);

// The files of a request, all that this server keeps, and what it may fetch until the deadline.
AssetResolver references(const Doors& doors, std::map<std::string, Blob> parts, const Deadline& deadline);

}  // namespace furnace
