#include "api/preset.hpp"

#include "api/contract.hpp"
#include "api/image_query.hpp"
#include "api/problem.hpp"
#include "api/validate.hpp"

#include <nlohmann/json.hpp>

#include <utility>

namespace furnace::api {
namespace {

using Json = nlohmann::json;

constexpr const char* kOpen = "furnace:open";

std::vector<std::string> read_open(const Value& list, std::vector<Problem>& problems) {
  std::vector<std::string> open;
  if (!list) return open;
  if (list.type() != JsonType::kArray) problems.push_back({list.pointer(), "must be a list of flat keys"});
  for (std::size_t i = 0; i < list.size() && list.type() == JsonType::kArray; ++i) {
    const Value key = list.at(i);
    if (key.type() != JsonType::kText || find_query_key(key.text()) == nullptr)
      problems.push_back({key.pointer(), "must be a flat key of GET /v1/render, got " + key.excerpt()});
    else
      open.emplace_back(key.text());
  }
  return open;
}

}  // namespace

Preset parse_preset(std::string_view text, const JsonLimits& limits) {
  static const Schema schema(render_request_schema());
  const Document whole = Document::parse(text, limits);
  Preset preset;
  std::vector<Problem> problems;
  preset.open = read_open(whole.root()[kOpen], problems);
  Json request = *static_cast<const Json*>(whole.root().native());
  if (request.is_object()) request.erase(kOpen);
  preset.document = request.dump();
  for (Problem& problem : schema.problems(Document::parse(preset.document, limits)))
    problems.push_back(std::move(problem));
  fail_if_any(std::move(problems));
  return preset;
}

std::string preset_names_json(const std::map<std::string, Preset, std::less<>>& presets) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& [name, preset] : presets) list.push_back({{"name", name}, {"open", preset.open}});
  return nlohmann::ordered_json({{"presets", list}}).dump(2) + "\n";
}

}  // namespace furnace::api
