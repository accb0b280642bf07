// Pixels of a render target -> Image.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/gl/gl.hpp"
#include "renderer/image/image.hpp"

namespace furnace::gl {

// Reads the RGBA pixels of color attachment 0 into the rectangle of `image` whose top left is (x, y).
// `image` has 4 channels; its type says how the pixels are read.
void read_pixels(Context&, const Framebuffer& framebuffer, Extent size, Image& image, int x, int y);

// Rows of one of the two numbers of a texel (0 or 1) of an RG32UI attachment, from its top left.
std::vector<std::uint32_t> read_numbers(Context&, const Framebuffer& framebuffer, Extent size, int which);

}  // namespace furnace::gl
