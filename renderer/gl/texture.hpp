// Textures, samplers and render targets by intent.
#pragma once

#include <map>
#include <span>

#include "renderer/gl/gl.hpp"
#include "renderer/image/image.hpp"
#include "renderer/scene/material.hpp"

namespace furnace::gl {

// Full chain down to 1x1.
int mip_levels(Extent extent);

// An immutable 2D texture; `levels` >= 1.
Texture create_texture(Context&, GLenum internal_format, Extent extent, int levels);

// The same as an array of `layers` with one level each.
Texture create_texture_array(Context&, GLenum internal_format, Extent extent, int layers);

// Creates and fills level 0 from a tightly packed 1..4 channel image, then builds the chain when `mipmapped`.
// kUint8: GL_SRGB8_ALPHA8 for kSrgb (4 channels only), else RGBA8/RG8/R8 kinds; kUint16: 16-bit normalised; kFloat16/32 likewise.
// Errors: kTooLarge over the context's texture size, kGpuUnavailable when memory is out.
Texture upload_texture(Context&, const Image& image, bool mipmapped);

// Fills the first levels of a whole chain, then builds those that are left from the last one. Each of `levels` is half
// as large as the one before, rounded down; formats and errors as above.
Texture upload_levels(Context&, std::span<const Image> levels);

// `color` or `depth` may be empty. Errors: kGpuUnavailable when incomplete.
Framebuffer create_framebuffer(Context&, const Texture& color, const Texture& depth);

// The few samplers a context needs, each made once. Threads: the context's. Owns: its samplers.
class SamplerCache {
 public:
  GLuint get(Context&, const SamplerDesc& desc);

 private:
  std::map<std::uint32_t, Sampler> samplers_;
};

}  // namespace furnace::gl
