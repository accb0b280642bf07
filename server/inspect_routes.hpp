// POST /v1/inspect: what is in a model.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "renderer/base/blob.hpp"
#include "server/http_types.hpp"
#include "server/routes.hpp"

namespace furnace {

// The body is a document that names the model, with parts or without, or the model itself. Takes a seat, as a render
// does. Errors: those of parse_inspect_request and inspect_gltf, kOverloaded.
Reply post_inspect(const Doors& doors, const Request& request);

// The same for a document and the files beside it.
Reply inspect_model(const Doors& doors, std::string_view document, std::map<std::string, Blob> parts,
                    const Deadline& deadline);

}  // namespace furnace
