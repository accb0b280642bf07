// A photographic studio: a graded room and soft boxes.
#pragma once

#include "renderer/image/image.hpp"
#include "renderer/scene/procedural_environment.hpp"

namespace furnace {

Image paint_studio(const StudioEnvironment& studio);

Image make_studio();  // the default light: 1024 x 512

}  // namespace furnace
