// Standard skies over a plain: overcast after CIE, clear by scattering, clear after Preetham.
#pragma once

#include "renderer/image/image.hpp"
#include "renderer/scene/procedural_environment.hpp"

namespace furnace {

Image paint_overcast(const OvercastEnvironment& overcast);  // 256 x 128
Image paint_clear_sky(const ClearSkyEnvironment& sky, const Painting& painting);

// Preetham's sky, with a sun of true size at 45 degrees: 1024 x 512; horizontal irradiance pi in each channel,
// sun included.
Image make_clear_sky();

}  // namespace furnace
