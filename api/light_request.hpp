// The objects that describe lights, after the schema was satisfied.
#pragma once

#include "api/request_values.hpp"
#include "renderer/assets/asset_resolver.hpp"
#include "renderer/scene/light.hpp"

namespace furnace::api {

// With the file of its profile, if it has one.
Light read_light(const Value& value, const AssetResolver& assets, Faults& faults);

}  // namespace furnace::api
