// Where in the client's document an error of a model's file is told.
#pragma once

#include <string>
#include <string_view>

#include "renderer/base/error.hpp"

namespace furnace {

// Runs `import`. The pointer of an Error that leaves it leads into the file: its message tells it, and the Error is at
// `place`, where the client's document names the file.
// Example: import_for("/scene/model", [&] { return import_gltf(...); })
template <class Import>
auto import_for(std::string_view place, Import&& import) -> decltype(import()) {
  constexpr std::string_view kWholeFile = "/scene/model";  // of import_model
  try {
    return with_context(place, import);
  } catch (Error& error) {
    if (error.pointer.empty()) throw;
    if (error.pointer != kWholeFile) error.message = error.pointer + " of the file: " + error.message;
    error.pointer = place;
    throw;
  }
}

}  // namespace furnace
