#include "renderer/gl/readback.hpp"

namespace furnace::gl {
namespace {

GLenum transfer_type(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return GL_UNSIGNED_BYTE;
    case SampleType::kUint16:
      return GL_UNSIGNED_SHORT;
    case SampleType::kFloat16:
      return GL_HALF_FLOAT;
    case SampleType::kFloat32:
      return GL_FLOAT;
  }
  return GL_FLOAT;
}

}  // namespace

void read_pixels(Context&, const Framebuffer& framebuffer, Extent size, Image& image, int x, int y) {
  const std::size_t pixel_bytes = std::size_t(image.channels) * sample_bytes(image.type);
  std::byte* first = image.pixels.data() + (std::size_t(y) * image.extent.width + x) * pixel_bytes;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.id());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ROW_LENGTH, image.extent.width);
  glReadPixels(0, 0, size.width, size.height, GL_RGBA, transfer_type(image.type), first);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
}

std::vector<std::uint32_t> read_numbers(Context&, const Framebuffer& framebuffer, Extent size, int which) {
  std::vector<std::uint32_t> numbers(std::size_t(size.area()));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.id());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.width, size.height, which == 0 ? GL_RED_INTEGER : GL_GREEN_INTEGER, GL_UNSIGNED_INT,
               numbers.data());
  return numbers;
}

}  // namespace furnace::gl
