// Pictures made smaller: the mean over the area that a pixel covers, exactly, in linear light.
#pragma once

#include "renderer/image/image.hpp"

namespace furnace {

// `extent` must not be larger than the image's on either side. kUint8 and kUint16; colours of kSrgb are averaged as
// light, alpha and data as they are. Threads: any.
Image downscaled(const Image& image, Extent extent);

// The largest extent of the same shape whose sides are at most `side_px`.
Extent fitted(Extent extent, int side_px);

}  // namespace furnace
