#include "renderer/gl/texture.hpp"

#include <algorithm>
#include <bit>
#include <string>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

namespace furnace::gl {
namespace {

struct Format {
  GLenum internal;
  GLenum transfer;
  GLenum type;
};

Format format_of(const Image& image) {
  constexpr GLenum kTransfer[] = {GL_RED, GL_RG, GL_RGB, GL_RGBA};
  constexpr GLenum kInternal[][4] = {{GL_R8, GL_RG8, GL_RGB8, GL_RGBA8},
                                     {GL_R16, GL_RG16, GL_RGB16, GL_RGBA16},
                                     {GL_R16F, GL_RG16F, GL_RGB16F, GL_RGBA16F},
                                     {GL_R32F, GL_RG32F, GL_RGB32F, GL_RGBA32F}};
  constexpr GLenum kType[] = {GL_UNSIGNED_BYTE, GL_UNSIGNED_SHORT, GL_HALF_FLOAT, GL_FLOAT};
  const auto type = std::size_t(image.type);
  const auto channel = std::size_t(image.channels - 1);
  const bool srgb =
      image.color_space == ColorSpace::kSrgb && image.type == SampleType::kUint8 && image.channels == 4;
  return {srgb ? GLenum(GL_SRGB8_ALPHA8) : kInternal[type][channel], kTransfer[channel], kType[type]};
}

void check_memory(const char* what) {
  if (glGetError() == GL_OUT_OF_MEMORY) {
    fail(ErrorCode::kGpuUnavailable, std::string("the GPU has no memory left for ") + what);
  }
}

void check_size(const Context& context, Extent extent) {
  const int limit = context.limits().max_texture_px;
  if (extent.width <= limit && extent.height <= limit) return;
  fail(ErrorCode::kTooLarge, "a texture of " + std::to_string(extent.width) + "x" +
                                 std::to_string(extent.height) + " px exceeds this GPU's limit of " +
                                 std::to_string(limit) + " px a side");
}

void fill_level(const Texture& texture, GLint level, const Image& image) {
  const Format format = format_of(image);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.id(), level, 0, 0, image.extent.width, image.extent.height, format.transfer,
                      format.type, image.pixels.data());
}

GLint wrap_mode(Wrap wrap) {
  switch (wrap) {
    case Wrap::kRepeat:
      return GL_REPEAT;
    case Wrap::kMirroredRepeat:
      return GL_MIRRORED_REPEAT;
    case Wrap::kClampToEdge:
      return GL_CLAMP_TO_EDGE;
  }
  return GL_REPEAT;
}

GLint min_filter(const SamplerDesc& desc) {
  const bool linear = desc.min == Filter::kLinear;
  switch (desc.mip) {
    case MipFilter::kNone:
      return linear ? GL_LINEAR : GL_NEAREST;
    case MipFilter::kNearest:
      return linear ? GL_LINEAR_MIPMAP_NEAREST : GL_NEAREST_MIPMAP_NEAREST;
    case MipFilter::kLinear:
      return linear ? GL_LINEAR_MIPMAP_LINEAR : GL_NEAREST_MIPMAP_LINEAR;
  }
  return GL_LINEAR;
}

}  // namespace

int mip_levels(Extent extent) {
  return std::bit_width(unsigned(std::max({extent.width, extent.height, 1})));
}

Texture create_texture(Context& context, GLenum internal_format, Extent extent, int levels) {
  check_size(context, extent);
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &id);
  Texture texture(id);
  glTextureStorage2D(id, levels, internal_format, extent.width, extent.height);
  check_memory("a texture");
  return texture;
}

Texture create_texture_array(Context& context, GLenum internal_format, Extent extent, int layers) {
  check_size(context, extent);
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  Texture texture(id);
  glTextureStorage3D(id, 1, internal_format, extent.width, extent.height, layers);
  check_memory("a texture");
  return texture;
}

Texture upload_texture(Context& context, const Image& image, bool mipmapped) {
  if (mipmapped) return upload_levels(context, {&image, 1});
  const Format format = format_of(image);
  Texture texture = create_texture(context, format.internal, image.extent, 1);
  fill_level(texture, 0, image);
  check_memory("a texture");
  return texture;
}

Texture upload_levels(Context& context, std::span<const Image> levels) {
  const Extent extent = levels.front().extent;
  const int whole = mip_levels(extent), given = int(levels.size());
  Texture texture = create_texture(context, format_of(levels.front()).internal, extent, whole);
  for (int level = 0; level < given; ++level) {
    const Image& image = levels[std::size_t(level)];
    const Extent due{std::max(extent.width >> level, 1), std::max(extent.height >> level, 1)};
    FURNACE_CHECK(level < whole && image.extent == due, "level {} of {} has {} x {} px", level, whole,
                  image.extent.width, image.extent.height);
    fill_level(texture, level, image);
  }
  if (given < whole) {
    glTextureParameteri(texture.id(), GL_TEXTURE_BASE_LEVEL, given - 1);
    glGenerateTextureMipmap(texture.id());
    glTextureParameteri(texture.id(), GL_TEXTURE_BASE_LEVEL, 0);
  }
  check_memory("a texture");
  return texture;
}

Framebuffer create_framebuffer(Context&, const Texture& color, const Texture& depth) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  Framebuffer framebuffer(id);
  if (color) {
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color.id(), 0);
  } else {
    glNamedFramebufferDrawBuffer(id, GL_NONE);
  }
  if (depth) glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth.id(), 0);
  if (glCheckNamedFramebufferStatus(id, GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    fail(ErrorCode::kGpuUnavailable, "this GPU cannot draw into the frame's format");
  }
  return framebuffer;
}

GLuint SamplerCache::get(Context&, const SamplerDesc& desc) {
  const std::uint32_t key = std::uint32_t(desc.wrap_u) | std::uint32_t(desc.wrap_v) << 2 |
                            std::uint32_t(desc.mag) << 4 | std::uint32_t(desc.min) << 5 |
                            std::uint32_t(desc.mip) << 6;
  const auto [entry, fresh] = samplers_.try_emplace(key);
  if (fresh) {
    GLuint id = 0;
    glCreateSamplers(1, &id);
    entry->second = Sampler(id);
    glSamplerParameteri(id, GL_TEXTURE_WRAP_S, wrap_mode(desc.wrap_u));
    glSamplerParameteri(id, GL_TEXTURE_WRAP_T, wrap_mode(desc.wrap_v));
    glSamplerParameteri(id, GL_TEXTURE_MAG_FILTER, desc.mag == Filter::kLinear ? GL_LINEAR : GL_NEAREST);
    glSamplerParameteri(id, GL_TEXTURE_MIN_FILTER, min_filter(desc));
  }
  return entry->second.id();
}

}  // namespace furnace::gl
