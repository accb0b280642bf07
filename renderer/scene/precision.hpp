// Single precision, in which scenes are held and drawn, is fine near the origin and coarse far from it.
#pragma once

#include <optional>

#include "renderer/scene/scene.hpp"

namespace furnace {

// A note if the scene lies so far from the origin for its size that the steps between numbers may show. Cheap: by the
// boxes of its meshes.
std::optional<Note> precision_note(const Scene& scene);

}  // namespace furnace
