// Repro bundles: a picture, and all that it takes to draw it again elsewhere, in one file.
#pragma once

#include "server/routes.hpp"

namespace furnace {

// POST /v1/bundles: takes what POST /v1/renders takes, and answers with a ZIP that `furnace render` draws again.
// Errors: as POST /v1/renders; kTooLarge when its files have more than Doors::max_bundle_bytes together.
Reply post_bundle(const Doors& doors, const Request& request);

}  // namespace furnace
