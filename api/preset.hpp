// A render request that the operator keeps under a name, for image URLs.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/document.hpp"

namespace furnace::api {

struct Preset {
  std::string document;           // a render request, as JSON
  std::vector<std::string> open;  // flat keys that may be laid over it where only presets are drawn
};

// A render request; its member "furnace:open" is a list of flat keys and no part of the request. What only shows with
// the limits and files of a server is not looked at. Errors: those of Document::parse; kUnprocessable with all problems.
Preset parse_preset(std::string_view text, const JsonLimits& limits);

// {"presets": [{"name", "open"}]}, by name.
std::string preset_names_json(const std::map<std::string, Preset, std::less<>>& presets);

}  // namespace furnace::api
