// The only include of GL and EGL headers, and the move-only owners of GL objects. No loader: libOpenGL exports the core.
#pragma once

#ifndef GL_GLEXT_PROTOTYPES
#define GL_GLEXT_PROTOTYPES
#endif
#include <GL/glcorearb.h>

#include <utility>

#include "renderer/gl/context.hpp"

namespace furnace::gl {

// A GL name that is deleted with its owner. An empty object holds 0.
// Threads: the context's. Owns: one GL object.
template <class Traits>
class Object {
 public:
  Object() = default;
  explicit Object(GLuint id) : id_(id) {}
  Object(Object&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  ~Object() {
    if (id_ != 0) Traits::destroy(id_);
  }

  GLuint id() const { return id_; }
  explicit operator bool() const { return id_ != 0; }

 private:
  GLuint id_ = 0;
};

struct BufferTraits {
  static void destroy(GLuint id) { glDeleteBuffers(1, &id); }
};
struct TextureTraits {
  static void destroy(GLuint id) { glDeleteTextures(1, &id); }
};
struct SamplerTraits {
  static void destroy(GLuint id) { glDeleteSamplers(1, &id); }
};
struct VertexArrayTraits {
  static void destroy(GLuint id) { glDeleteVertexArrays(1, &id); }
};
struct FramebufferTraits {
  static void destroy(GLuint id) { glDeleteFramebuffers(1, &id); }
};
struct ShaderTraits {
  static void destroy(GLuint id) { glDeleteShader(id); }
};
struct ProgramTraits {
  static void destroy(GLuint id) { glDeleteProgram(id); }
};

using Buffer = Object<BufferTraits>;
using Texture = Object<TextureTraits>;
using Sampler = Object<SamplerTraits>;
using VertexArray = Object<VertexArrayTraits>;
using Framebuffer = Object<FramebufferTraits>;
using Shader = Object<ShaderTraits>;
using Program = Object<ProgramTraits>;

// An immutable buffer filled with `bytes` (never of size 0 in GL: an empty one gets 16 bytes).
Buffer create_buffer(Context&, const void* data, std::size_t bytes);
VertexArray create_vertex_array(Context&);
// `buffer` as a texture of texels in `internal_format`; lives no longer than the buffer.
Texture create_buffer_texture(Context&, GLenum internal_format, const Buffer& buffer);

}  // namespace furnace::gl
