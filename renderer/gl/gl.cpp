#include "renderer/gl/gl.hpp"

#include <algorithm>

namespace furnace::gl {

Buffer create_buffer(Context&, const void* data, std::size_t bytes) {
  GLuint id = 0;
  glCreateBuffers(1, &id);
  Buffer buffer(id);
  constexpr std::size_t kSmallest = 16;
  glNamedBufferStorage(id, GLsizeiptr(std::max(bytes, kSmallest)), bytes >= kSmallest ? data : nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  if (bytes > 0 && bytes < kSmallest) glNamedBufferSubData(id, 0, GLsizeiptr(bytes), data);
  return buffer;
}

Texture create_buffer_texture(Context&, GLenum internal_format, const Buffer& buffer) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
  glTextureBuffer(id, internal_format, buffer.id());
  return Texture(id);
}

VertexArray create_vertex_array(Context&) {
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  return VertexArray(id);
}

}  // namespace furnace::gl
