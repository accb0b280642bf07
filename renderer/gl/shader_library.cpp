#include "renderer/gl/shader_library.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <regex>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "embedded_shaders.hpp"
#include "renderer/base/error.hpp"

namespace furnace::gl {
namespace {

constexpr std::string_view kFeaturesPath = "interface/features.glsl";

// "FEATURE_X" tokens of a line, wherever they stand.
std::vector<std::string> feature_tokens(const std::string& line) {
  static const std::regex kToken("\\bFEATURE_\\w*");
  std::vector<std::string> tokens;
  if (line.find("FEATURE_") == std::string::npos) return tokens;
  for (std::sregex_iterator at(line.begin(), line.end(), kToken), end; at != end; ++at)
    tokens.push_back(at->str());
  return tokens;
}

// The path of `#include "path"`, or empty.
std::string included_path(const std::string& line) {
  static const std::regex kInclude("^\\s*#\\s*include\\s+\"([^\"]+)\"\\s*$");
  if (line.find("include") == std::string::npos) return {};
  std::smatch match;
  return std::regex_match(line, match, kInclude) ? match[1].str() : std::string();
}

}  // namespace

std::string map_driver_log(std::string_view log, const ExpandedShader& shader) {
  // Mesa "0:L(C): ", NVIDIA "0(L) : ", Intel and AMD "ERROR: 0:L: ".
  static const std::regex kPlace("\\b0:(\\d+)(?:\\(\\d+\\))?|\\b0\\((\\d+)\\)");
  std::string mapped;
  const std::string text(log);
  auto last = text.cbegin();
  for (std::sregex_iterator at(text.begin(), text.end(), kPlace), end; at != end; ++at) {
    const std::string digits = (*at)[1].matched ? (*at)[1].str() : (*at)[2].str();
    std::size_t line = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), line);
    mapped.append(last, text.cbegin() + at->position());
    if (line >= 1 && line <= shader.lines.size()) {
      const SourceLine& place = shader.lines[line - 1];
      mapped += fmt::format("shaders/{}:{}", place.path, place.line);
    } else {
      mapped += at->str();
    }
    last = text.cbegin() + at->position() + at->length();
  }
  mapped.append(last, text.cend());
  return mapped;
}

ShaderLibrary::ShaderLibrary(std::filesystem::path directory) : directory_(std::move(directory)) {}

const std::string& ShaderLibrary::source(const std::string& path) {
  const auto known = sources_.find(path);
  if (known != sources_.end()) return known->second.text;
  Source source;
  if (directory_.empty()) {
    const auto text = embedded_file(embedded_shaders(), path);
    if (!text) fail(ErrorCode::kInternal, fmt::format("there is no shader {}", path));
    source.text = std::string(*text);
  } else {
    std::ifstream file(directory_ / path, std::ios::binary);
    if (!file)
      fail(ErrorCode::kInternal, fmt::format("cannot read the shader {}", (directory_ / path).string()));
    std::ostringstream text;
    text << file.rdbuf();
    source.text = text.str();
    source.modified = std::filesystem::last_write_time(directory_ / path);
  }
  return sources_.emplace(path, std::move(source)).first->second.text;
}

std::vector<std::string> ShaderLibrary::feature_names() {
  std::vector<std::string> names;
  std::istringstream lines(source(std::string(kFeaturesPath)));
  static const std::regex kRow("^// (FEATURE_\\w+)\\s+\\S.*$");
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, kRow)) names.push_back(match[1].str());
  }
  return names;
}

void ShaderLibrary::append(const std::string& path, std::vector<std::string>& chain,
                           std::vector<std::string>& done, const std::vector<std::string>& features,
                           ExpandedShader& out) {
  if (std::find(chain.begin(), chain.end(), path) != chain.end()) {
    fail(ErrorCode::kInternal,
         fmt::format("shader includes form a cycle: {} -> {}", fmt::join(chain, " -> "), path));
  }
  if (std::find(done.begin(), done.end(), path) != done.end()) return;
  chain.push_back(path);
  std::istringstream lines(source(path));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string include = included_path(line);
    if (!include.empty()) {
      append(include, chain, done, features, out);
      continue;
    }
    for (const std::string& token : feature_tokens(line)) {
      if (std::find(features.begin(), features.end(), token) == features.end()) {
        fail(ErrorCode::kInternal,
             fmt::format("shaders/{}:{}: {} is not in shaders/{}", path, number, token, kFeaturesPath));
      }
    }
    out.text += line + "\n";
    out.lines.push_back({path, number});
  }
  chain.pop_back();
  done.push_back(path);
}

ExpandedShader ShaderLibrary::expand(const std::string& path, FeatureSet features) {
  ExpandedShader shader;
  const auto add = [&](const std::string& line) {
    shader.text += line + "\n";
    shader.lines.push_back({"(generated)", int(shader.lines.size()) + 1});
  };
  add("#version 450 core");
  const std::vector<std::string> names = feature_names();
  for (std::size_t bit = 0; bit < names.size(); ++bit) {
    add(fmt::format("#define {} {}", names[bit], features >> bit & 1u));
  }
  std::vector<std::string> chain, done;
  append(path, chain, done, names, shader);
  return shader;
}

ContentHash ShaderLibrary::hash() {
  HashBuilder builder;
  // The embedded list names the files of either kind.
  for (const EmbeddedFile& file : embedded_shaders()) {
    const std::string path(file.path);
    builder.add(file.path).add(source(path));
  }
  return builder.finish();
}

bool ShaderLibrary::reload_if_changed() {
  if (directory_.empty()) return false;
  for (const auto& [path, source] : sources_) {
    std::error_code gone;
    const auto modified = std::filesystem::last_write_time(directory_ / path, gone);
    if (gone || modified == source.modified) continue;
    sources_.clear();
    return true;
  }
  return false;
}

}  // namespace furnace::gl
