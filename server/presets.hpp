// The presets of image URLs: NAME.json in one folder.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "api/preset.hpp"

namespace furnace {

// Threads: immutable. Owns: the documents.
class Presets {
 public:
  Presets() = default;  // none
  // Reads each *.json of `folder`; names are letters, digits, ".", "_" and "-". Errors: kUnprocessable with the problems of
  // all files, the file's name before each pointer.
  Presets(const std::filesystem::path& folder, const api::JsonLimits& limits);

  const api::Preset* find(std::string_view name) const;
  std::string names_json() const { return api::preset_names_json(presets_); }

 private:
  std::map<std::string, api::Preset, std::less<>> presets_;
};

}  // namespace furnace
