// Programs by exact key: compiled on first use, kept, rebuilt when their sources change.
#pragma once

#include <compare>
#include <map>
#include <string>

#include "renderer/gl/gl.hpp"
#include "renderer/gl/shader_library.hpp"

namespace furnace::gl {

struct ProgramKey {
  std::string vertex;  // path of the vertex shader, or of the compute shader when `fragment` is empty
  std::string fragment;
  FeatureSet features = 0;

  auto operator<=>(const ProgramKey&) const = default;
};

// Errors: kInternal with the driver's log mapped to shader files and lines.
Program build_program(Context&, ShaderLibrary& library, const ProgramKey& key);

// Threads: the context's. Owns: its programs and the library.
class ProgramCache {
 public:
  explicit ProgramCache(std::string shader_dir) : library_(std::move(shader_dir)) {}

  GLuint request(Context&, const ProgramKey& key);
  // Between frames: when a shader file has changed, rebuilds every program; one that fails keeps its old form and is logged.
  void poll_sources(Context&);
  ShaderLibrary& shaders() { return library_; }

 private:
  ShaderLibrary library_;
  std::map<ProgramKey, Program> programs_;
};

}  // namespace furnace::gl
