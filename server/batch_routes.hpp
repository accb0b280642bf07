// POST /v1/batches: many renders in one archive.
#pragma once

#include "api/stored_render.hpp"
#include "server/request_body.hpp"
#include "server/routes.hpp"

namespace furnace {

inline constexpr std::string_view kBatches = "/v1/batches";

// Every item is understood before the first is drawn. One that cannot be drawn is told in the archive's index.json, and the rest
// goes on; when none can be, the first one's error is thrown. Hears how many are done.
// Errors: those of parse_batch and of parse_spec; kOverloaded, kDeadlineExceeded.
api::StoredRender draw_batch(const Doors& doors, const RequestBody& body, const Deadline& deadline,
                             const TellProgress& progress);

Reply post_batch(const Doors& doors, const Request& request);

}  // namespace furnace
