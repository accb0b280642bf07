// GLSL sources, from the binary or from a folder: includes expanded, features checked, lines remembered.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "renderer/gl/feature_set.hpp"

namespace furnace::gl {

struct SourceLine {
  std::string path;
  int line = 0;  // from 1
};

struct ExpandedShader {
  std::string text;               // with #version, a FEATURE_ define each, every include once
  std::vector<SourceLine> lines;  // of each line of `text`
};

// A driver's log with every "0:12(7)" or "0(12)" of the expanded text replaced by "shaders/lib/brdf.glsl:42".
std::string map_driver_log(std::string_view log, const ExpandedShader& shader);

// Threads: one. Owns: the texts read so far.
class ShaderLibrary {
 public:
  // Empty: the shaders in the binary.
  explicit ShaderLibrary(std::filesystem::path directory);

  // Errors: kInternal for a missing file, an include cycle (with its chain) or an unknown FEATURE_ name (file:line).
  ExpandedShader expand(const std::string& path, FeatureSet features);

  std::vector<std::string> feature_names();
  // A source beside the files: a test's own shader.
  void add(const std::string& path, std::string text) { sources_[path] = {std::move(text), {}}; }
  // Of every file, for the fingerprint.
  ContentHash hash();
  // True when a file in the folder has changed since it was read; the texts are then forgotten. Never for the binary's.
  bool reload_if_changed();

 private:
  struct Source {
    std::string text;
    std::filesystem::file_time_type modified;
  };
  const std::string& source(const std::string& path);
  void append(const std::string& path, std::vector<std::string>& chain, std::vector<std::string>& done,
              const std::vector<std::string>& features, ExpandedShader& out);

  std::filesystem::path directory_;
  std::map<std::string, Source> sources_;
};

}  // namespace furnace::gl
