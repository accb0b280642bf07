// The routes below /v1/environments.
#pragma once

#include <vector>

#include "server/dispatcher.hpp"
#include "server/environment_registry.hpp"

namespace furnace {

// `registry` outlives the routes.
std::vector<Route> environment_routes(EnvironmentRegistry& registry);

}  // namespace furnace
