#include "renderer/gl/program.hpp"

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"

namespace furnace::gl {
namespace {

Shader compile(ShaderLibrary& library, GLenum stage, const std::string& path, FeatureSet features) {
  const ExpandedShader source = library.expand(path, features);
  Shader shader(glCreateShader(stage));
  const char* text = source.text.c_str();
  glShaderSource(shader.id(), 1, &text, nullptr);
  glCompileShader(shader.id());
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  GLint length = 0;
  glGetShaderiv(shader.id(), GL_INFO_LOG_LENGTH, &length);
  std::string log(std::size_t(length > 0 ? length : 1), '\0');
  glGetShaderInfoLog(shader.id(), length, nullptr, log.data());
  fail(ErrorCode::kInternal, fmt::format("shaders/{} does not compile", path), {},
       map_driver_log(log, source));
}

}  // namespace

Program build_program(Context&, ShaderLibrary& library, const ProgramKey& key) {
  const bool is_compute = key.fragment.empty();
  Program program(glCreateProgram());
  const Shader first =
      compile(library, is_compute ? GL_COMPUTE_SHADER : GL_VERTEX_SHADER, key.vertex, key.features);
  glAttachShader(program.id(), first.id());
  Shader second;
  if (!is_compute) {
    second = compile(library, GL_FRAGMENT_SHADER, key.fragment, key.features);
    glAttachShader(program.id(), second.id());
  }
  glLinkProgram(program.id());
  GLint linked = GL_FALSE;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    GLint length = 0;
    glGetProgramiv(program.id(), GL_INFO_LOG_LENGTH, &length);
    std::string log(std::size_t(length > 0 ? length : 1), '\0');
    glGetProgramInfoLog(program.id(), length, nullptr, log.data());
    fail(ErrorCode::kInternal, fmt::format("shaders/{} and {} do not link", key.vertex, key.fragment), {},
         log);
  }
  glDetachShader(program.id(), first.id());
  if (second) glDetachShader(program.id(), second.id());
  return program;
}

GLuint ProgramCache::request(Context& context, const ProgramKey& key) {
  auto known = programs_.find(key);
  if (known == programs_.end()) known = programs_.emplace(key, build_program(context, library_, key)).first;
  return known->second.id();
}

void ProgramCache::poll_sources(Context& context) {
  if (!library_.reload_if_changed()) return;
  for (auto& [key, program] : programs_) {
    try {
      program = build_program(context, library_, key);
    } catch (const Error& error) {
      log::error("shader.reload", {{"message", error.message}, {"detail", error.detail}});
    }
  }
}

}  // namespace furnace::gl
