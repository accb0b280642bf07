// Standard skies over a plain of albedo 0.2: overcast after CIE, clear after Preetham with a sun of true
// size.
#pragma once

#include "renderer/image/image.hpp"

namespace furnace {

Image make_overcast_sky();  // 256 x 128; horizontal irradiance pi
Image make_clear_sky();     // 1024 x 512; horizontal irradiance pi in each channel, sun included

}  // namespace furnace
