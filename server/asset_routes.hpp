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

// The files of a request and all that this server keeps.
AssetResolver references(const Doors& doors, std::map<std::string, Blob> parts);

}  // namespace furnace
