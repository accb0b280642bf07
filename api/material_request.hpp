// The objects that describe materials, after the schema was satisfied.
#pragma once

#include "api/request_values.hpp"
#include "renderer/assets/asset_resolver.hpp"
#include "renderer/scene/render_spec.hpp"

namespace furnace::api {

void read_shading_model(const Value& value, ShadingModel& target);

// A preset's name or an object, with the files of its textures.
MaterialOverride read_material(const Value& value, const AssetResolver& assets, Faults& faults);

}  // namespace furnace::api
