// Pixels of a render target -> Image.
#pragma once

#include "renderer/gl/gl.hpp"
#include "renderer/image/image.hpp"

namespace furnace::gl {

// Reads the RGBA pixels of color attachment 0 into the rectangle of `image` whose top left is (x, y).
// `image` has 4 channels; its type says how the pixels are read.
void read_pixels(Context&, const Framebuffer& framebuffer, Extent size, Image& image, int x, int y);

}  // namespace furnace::gl
