// "model" and "files" of a request: a model, and what stands for the files that it names.
#pragma once

#include <memory>

#include "api/request_values.hpp"
#include "renderer/assets/asset_resolver.hpp"

namespace furnace::api {

// `files` may be absent. Null when something could not be read; `faults` tells what, and of files that the model does not name.
std::shared_ptr<const ModelBundle> read_model_reference(const Value& model, const Value& files,
                                                        const AssetResolver& assets, Faults& faults);

}  // namespace furnace::api
