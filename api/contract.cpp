#include "api/contract.hpp"

#include "api/image_query.hpp"
#include "renderer/scene/material.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/base/check.hpp"
#include "embedded_contract.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>

namespace furnace::api {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kSchemaPath = "schema/render_request.json";
constexpr std::string_view kProceduralPath = "schema/procedural_environment.json";
constexpr std::string_view kSchemaPlace = "#/components/schemas/RenderRequest";

std::string_view contract_file(std::string_view path) {
  const auto text = embedded_file(embedded_contract(), path);
  FURNACE_CHECK(text.has_value(), "no file {} in the binary", path);
  return *text;
}

// References inside the schema start at its own root; inside OpenAPI that root is a place in the document.
void move_references(OrderedJson& node) {
  if (node.is_object() && node.contains("$ref")) {
    std::string& reference = node["$ref"].get_ref<std::string&>();
    if (reference.starts_with("#/$defs/")) reference = std::string(kSchemaPlace) + reference.substr(1);
  }
  if (node.is_structured())
    for (OrderedJson& child : node) move_references(child);
}

// The node of a schema that a document's place `pointer` is held against.
const OrderedJson& schema_at(const OrderedJson& root, std::string_view pointer) {
  const OrderedJson* node = &root;
  while (!pointer.empty()) {
    while (node->contains("$ref"))
      node = &root.at(OrderedJson::json_pointer((*node)["$ref"].get_ref<const std::string&>().substr(1)));
    const std::size_t end = std::min(pointer.find('/', 1), pointer.size());
    const std::string token(pointer.substr(1, end - 1));
    pointer.remove_prefix(end);
    const bool is_item = node->contains("items");
    FURNACE_CHECK(is_item || node->value("properties", OrderedJson::object()).contains(token),
                  "the schema has no {}", token);
    node = is_item ? &(*node)["items"] : &(*node)["properties"][token];
  }
  return *node;
}

// Flat keys stand in one table; what they take is what their place takes.
void fill_in_query(OrderedJson& document, const OrderedJson& schema) {
  OrderedJson& parameters = document["paths"]["/v1/render"]["get"]["parameters"];
  for (const QueryKey& key : query_keys()) {
    OrderedJson parameter = {{"name", key.name},
                             {"in", "query"},
                             {"description", std::string(key.pointer) + " of the document."},
                             {"schema", schema_at(schema, key.pointer)}};
    if (key.kind == QueryKind::kNumbers) parameter.update({{"style", "form"}, {"explode", false}});  // 1,2,3
    move_references(parameter);
    parameters.push_back(std::move(parameter));
  }
}

// Names are written once, in the tables that implement them.
void fill_in_names(OrderedJson& schema, const char* definition, std::string_view prefix,
                   const std::vector<std::string_view>& names) {
  OrderedJson& choices = schema["$defs"][definition]["enum"] = OrderedJson::array();
  for (const std::string_view name : names) choices.push_back(std::string(prefix).append(name));
}

}  // namespace

std::string_view render_request_schema() {
  static const std::string text = [] {
    OrderedJson schema = OrderedJson::parse(contract_file(kSchemaPath));
    schema["$defs"].update(OrderedJson::parse(contract_file(kProceduralPath))["$defs"]);
    fill_in_names(schema, "presetName", "", material_preset_names());
    fill_in_names(schema, "meshName", "builtin:", builtin_mesh_names());
    return schema.dump(2);
  }();
  return text;
}

std::string_view inspect_request_schema() {
  static const std::string text =
      OrderedJson::parse(contract_file("openapi.json"))["components"]["schemas"]["InspectRequest"].dump(2);
  return text;
}

std::string openapi_document(std::string_view version) {
  OrderedJson document = OrderedJson::parse(contract_file("openapi.json"));
  OrderedJson schema = OrderedJson::parse(render_request_schema());
  fill_in_query(document, schema);
  schema.erase("$schema");
  schema.erase("$id");
  move_references(schema);
  OrderedJson& place = document["components"]["schemas"]["RenderRequest"];
  FURNACE_CHECK(place.value("$ref", "") == kSchemaPath, "openapi.json does not refer to the schema: {}",
                place.dump());
  place = std::move(schema);
  document["info"]["version"] = version;
  return document.dump(2);
}

}  // namespace furnace::api
