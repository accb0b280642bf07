// POST /v1/inspect: what is in a model.
#pragma once

#include "server/http_types.hpp"
#include "server/routes.hpp"

namespace furnace {

// The body is a document that names the model, with parts or without, or the model itself. Takes a seat, as a render
// does. Errors: those of parse_inspect_request and inspect_gltf, kOverloaded.
Reply post_inspect(const Doors& doors, const Request& request);

}  // namespace furnace
