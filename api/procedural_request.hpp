// The objects that describe an environment, after the schema was satisfied.
#pragma once

#include <optional>

#include "api/request_values.hpp"
#include "renderer/scene/procedural_environment.hpp"

namespace furnace::api {

// None for one radiance from everywhere, which is no picture.
std::optional<ProceduralEnvironment> read_procedural(const Value& map, Faults& faults);

}  // namespace furnace::api
