#include "renderer/gl/driver.hpp"

#include <string>

#include "renderer/base/log.hpp"
#include "renderer/gl/gl.hpp"

namespace furnace::gl {
namespace {

void APIENTRY on_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length, const GLchar* message,
                         const void*) {
  if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) return;
  log::warning("gl.error", {{"message", std::string(message, std::size_t(length < 0 ? 0 : length))}});
}

}  // namespace

void install_debug_output() {
  glEnable(GL_DEBUG_OUTPUT);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_FALSE);
  glDebugMessageControl(GL_DONT_CARE, GL_DEBUG_TYPE_ERROR, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  glDebugMessageControl(GL_DONT_CARE, GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  glDebugMessageCallback(on_message, nullptr);
}

}  // namespace furnace::gl
