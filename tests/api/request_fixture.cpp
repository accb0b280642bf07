#include "tests/api/request_fixture.hpp"

#include "api/contract.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace furnace::api {
namespace {

Value resolve(const Value& schema) {
  const Value reference = schema["$ref"];
  if (!reference) return schema;
  const std::string_view name = reference.text().substr(std::string_view("#/$defs/").size());
  return resolve(request_schema().document().root()["$defs"][name]);
}

void collect_leaves(const Value& declared, const std::string& path, std::vector<Leaf>& leaves);

// One kind of several, told apart by "type", which alone says nothing. Wherever the kinds may stand they are
// the same, so their place is left out and each is collected once.
void collect_kind(const Value& kind, const std::string& path, std::vector<Leaf>& leaves) {
  const auto is_below = [&](const Leaf& leaf) { return leaf.path.starts_with(path + "/"); };
  if (std::any_of(leaves.begin(), leaves.end(), is_below)) return;
  for (const auto& [key, property] : kind["properties"].members())
    if (key != "type") collect_leaves(property, path + "/" + key, leaves);
}

void collect_leaves(const Value& declared, const std::string& path, std::vector<Leaf>& leaves) {
  const Value schema = resolve(declared);
  if (const Value alternatives = schema["anyOf"]) {
    for (std::size_t i = 0; i < alternatives.size(); ++i) {
      const Value alternative = resolve(alternatives.at(i));
      if (const Value kind = alternative["properties"]["type"]["enum"])
        collect_kind(alternative, path.substr(path.rfind('/')) + ":" + std::string(kind.at(0).text()),
                     leaves);
      else if (alternatives.at(i)["$ref"].type() == JsonType::kText &&
               alternatives.at(i)["$ref"].text() == "#/$defs/textureMap")
        collect_kind(alternative, "/texture", leaves);
      else if (alternative["type"].text() == "object")
        collect_leaves(alternatives.at(i), path, leaves);
      else if (leaves.empty() || leaves.back().path != path)
        leaves.push_back({path, declared, schema});
    }
    return;
  }
  const std::string_view type = schema["type"].text();
  if (type == "object" && schema["additionalProperties"].type() == JsonType::kObject)
    return collect_leaves(schema["additionalProperties"], path, leaves);
  if (type == "object")
    for (const auto& [key, property] : schema["properties"].members())
      collect_leaves(property, path + "/" + key, leaves);
  else if (type == "array" && resolve(schema["items"])["type"].text() == "object")
    collect_leaves(schema["items"], path, leaves);
  else
    leaves.push_back({path, declared, schema});
}

}  // namespace

RenderSpec parse(std::string_view json, const RequestLimits& limits) {
  FileAssets files({}, 0, 0);
  std::map<std::string, Blob> parts;
  parts["model.gltf"] = Blob(R"({"asset":{"version":"2.0"}})");
  parts["chair.gltf"] = Blob(R"({"asset":{"version":"2.0"},"images":[{"uri":"oak.png"}]})");
  parts["model.obj"] = Blob("v 0 0 0\n");
  parts["sky.hdr"] = Blob("#?RADIANCE\n");
  const std::string png("\x89PNG\r\n\x1a\n", 8);  // enough to be taken for one: parsing does not decode
  parts["a.png"] = Blob(png);
  parts["b.png"] = Blob(png + "b");
  // An even lamp of so many candela.
  const auto lamp = [](std::string_view candela) {
    return fmt::format("TILT=NONE\n1 1 1 2 1 1 2 0 0 0 1 1 1\n0 180\n0\n{0} {0}\n", candela);
  };
  parts["a.ies"] = Blob(lamp("20"));
  parts["b.ies"] = Blob(lamp("30"));
  parts["broken.ies"] = Blob(lamp("-1"));
  return parse_render_request(json, AssetResolver(files, parts, {}), limits);
}

ContentHash hash_of(std::string_view json) {
  return spec_hash(parse(json, generous_limits()));
}

Error refusal(std::string_view json, const RequestLimits& limits) {
  try {
    parse(json, limits);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "accepted: " << json;
  return {};
}

const Schema& request_schema() {
  static const Schema schema(render_request_schema());
  return schema;
}

RequestLimits generous_limits() {
  RequestLimits limits;
  limits.max_side_px = limits.max_samples = limits.max_frames = 1 << 20;
  limits.max_area_px = std::int64_t{1} << 40;
  limits.max_layer_bytes = limits.max_sequence_px = std::int64_t{1} << 50;
  limits.max_json_bytes = std::int64_t{1} << 24;
  return limits;
}

std::string json_text(const Value& value) {
  std::vector<std::string> items;
  switch (value.type()) {
    case JsonType::kText:
      return quoted(value.text(), value.text().size());
    case JsonType::kArray:
      for (std::size_t i = 0; i < value.size(); ++i) items.push_back(json_text(value.at(i)));
      return fmt::format("[{}]", fmt::join(items, ","));
    case JsonType::kObject:
      for (const auto& [key, member] : value.members())
        items.push_back(fmt::format("{}:{}", quoted(key, key.size()), json_text(member)));
      return fmt::format("{{{}}}", fmt::join(items, ","));
    default:
      return value.excerpt();
  }
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string with_value(const FieldRow& row, std::string_view value) {
  std::string document(row.document);
  return document.replace(document.find('@'), 1, value);
}

// Rows that name their map's key ("m", "gold") lose that key with its value.
std::string without_field(const FieldRow& row) {
  std::string document(row.document);
  const std::size_t end = document.find('@') + 1;
  std::size_t begin = document.rfind('"', document.rfind("\":", end) - 1);
  if (begin > 0 && document[begin - 1] == ',') --begin;
  return document.erase(begin, end - begin);
}

std::vector<Leaf> schema_leaves() {
  std::vector<Leaf> leaves;
  collect_leaves(request_schema().document().root(), "", leaves);
  return leaves;
}

}  // namespace furnace::api
