// The default light: a photographic studio made of a graded room and soft boxes.
#pragma once

#include "renderer/image/image.hpp"

namespace furnace {

Image make_studio();  // 1024 x 512

}  // namespace furnace
