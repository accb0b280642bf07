// What is published is what is implemented: embedded files, OpenAPI with its examples, capabilities, version.
#include "api/contract.hpp"

#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "embedded_contract.hpp"

#include "api/capabilities.hpp"
#include "api/image_query.hpp"
#include "api/model_report.hpp"
#include "api/render_report.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/scene/procedural.hpp"
#include "tests/api/request_fixture.hpp"

namespace furnace::api {
namespace {

Document openapi() {
  return Document::parse(openapi_document("9.8.7"), {});
}

void for_each_value(const Value& value, const std::function<void(const Value&)>& visit) {
  visit(value);
  for (const auto& [key, member] : value.members()) for_each_value(member, visit);
  for (std::size_t i = 0; value.type() == JsonType::kArray && i < value.size(); ++i)
    for_each_value(value.at(i), visit);
}

Value follow(const Value& root, std::string_view reference) {
  EXPECT_TRUE(reference.starts_with("#/")) << reference;
  Value value = root;
  for (reference.remove_prefix(1); !reference.empty();) {
    const std::size_t end = std::min(reference.find('/', 1), reference.size());
    value = value[reference.substr(1, end - 1)];
    reference.remove_prefix(end);
  }
  return value;
}

// `part` of an OpenAPI document as a schema of its own.
std::vector<Problem> check_against(const Value& schema, std::string_view json) {
  return Schema(json_text(schema)).problems(Document::parse(json, {}));
}

TEST(Embedded, FilesAreTheFilesOfTheTree) {
  ASSERT_EQ(embedded_contract().size(), 3u);
  for (const EmbeddedFile& file : embedded_contract())
    EXPECT_TRUE(file.text == read_text("api/" + std::string(file.path))) << file.path;
  EXPECT_TRUE(embedded_file(embedded_contract(), "openapi.json"));
  EXPECT_FALSE(embedded_file(embedded_contract(), "openapi.jso"));
}

TEST(Contract, SchemaListsTheNamesThatAreBuiltIn) {
  const Document document = Document::parse(render_request_schema(), {});
  const Value definitions = document.root()["$defs"];
  ASSERT_EQ(definitions["presetName"]["enum"].size(), material_preset_names().size());
  ASSERT_EQ(definitions["meshName"]["enum"].size(), builtin_mesh_names().size());
  for (std::size_t i = 0; i < builtin_mesh_names().size(); ++i) {
    const std::string name = "builtin:" + std::string(builtin_mesh_names()[i]);
    EXPECT_EQ(definitions["meshName"]["enum"].at(i).text(), name);
    EXPECT_NO_THROW(parse(R"({"scene":{"nodes":[{"mesh":")" + name + "\"}]}}"));
  }
}

TEST(Contract, OpenApiContainsTheSchemaAndTheVersion) {
  const Document document = openapi();
  EXPECT_EQ(document.root()["openapi"].text(), "3.1.0");
  EXPECT_EQ(document.root()["info"]["version"].text(), "9.8.7");
  const Value place = document.root()["components"]["schemas"]["RenderRequest"];
  EXPECT_EQ(place["properties"].size(), request_schema().document().root()["properties"].size());
  EXPECT_FALSE(place["$ref"]);
}

TEST(Contract, EveryFlatKeyIsAParameterOfItsKind) {
  const Document document = openapi();
  const Value parameters = document.root()["paths"]["/v1/render"]["get"]["parameters"];
  std::map<std::string, Value, std::less<>> by_name;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters.at(i)["name"]) by_name.emplace(parameters.at(i)["name"].text(), parameters.at(i));
  for (const char* name : {"r", "preset", "kid", "exp", "sig"}) EXPECT_EQ(by_name.erase(name), 1u) << name;
  EXPECT_EQ(by_name.size(), query_keys().size());
  for (const QueryKey& key : query_keys()) {
    SCOPED_TRACE(key.name);
    const auto found = by_name.find(key.name);
    ASSERT_NE(found, by_name.end());
    Value schema = found->second["schema"];
    while (schema["$ref"]) schema = follow(document.root(), schema["$ref"].text());
    const bool is_text = key.kind == QueryKind::kText, is_flag = key.kind == QueryKind::kFlag;
    if (schema["anyOf"]) {
      EXPECT_TRUE(is_text);
      continue;
    }
    const std::string_view type = schema["type"].text();
    const std::string_view number = type == "integer" ? "integer" : "number";
    EXPECT_EQ(type, is_text                           ? "string"
                    : is_flag                         ? "boolean"
                    : key.kind == QueryKind::kNumbers ? "array"
                                                      : number);
  }
}

TEST(Contract, EveryReferenceLeadsSomewhere) {
  const Document document = openapi();
  int references = 0;
  for_each_value(document.root(), [&](const Value& value) {
    const Value reference = value["$ref"];
    if (reference.type() != JsonType::kText) return;
    ++references;
    EXPECT_TRUE(follow(document.root(), reference.text())) << reference.text();
  });
  EXPECT_GT(references, 30);
}

TEST(Contract, EveryRequestExampleIsAccepted) {
  const Document document = openapi();
  const Value content = document.root()["paths"]["/v1/renders"]["post"]["requestBody"]["content"];
  const Value examples = content["application/json"]["examples"];
  ASSERT_GE(examples.size(), 4u);
  for (const auto& [name, example] : examples.members()) {
    SCOPED_TRACE(name);
    EXPECT_NO_THROW(parse(json_text(example["value"])));
  }
  for (const auto& [name, example] : content["multipart/form-data"]["examples"].members()) {
    const Document request = Document::parse(json_text(example["value"]["request"]), {});
    EXPECT_TRUE(request_schema().problems(request).empty()) << name;
  }
}

TEST(Contract, EveryErrorIsAProblemDocument) {
  const Document document = openapi();
  for (const auto& [path, item] : document.root()["paths"].members())
    for (const auto& [method, operation] : item.members())
      for (const auto& [status, response] : operation["responses"].members()) {
        if (status[0] < '4') continue;
        const Value resolved = follow(document.root(), response["$ref"].text());
        EXPECT_TRUE(resolved["content"]["application/problem+json"]) << path << " " << status;
      }
}

TEST(Contract, ProblemExampleIsWhatSuchARequestGets) {
  const Document document = openapi();
  const Value schema = document.root()["components"]["schemas"]["Problem"];
  const Error error = refusal(R"({"output":{"width":0}})");
  EXPECT_THAT(check_against(schema, json_text(schema["examples"].at(0))), testing::IsEmpty());
  EXPECT_EQ(schema["examples"].at(0)["detail"].text(), error.message);
}

// A schema of components, with all that it refers to.
std::vector<Problem> check_component(const std::string& name, std::string_view json) {
  const Document document = openapi();
  const std::string schema = R"({"$ref":"#/components/schemas/)" + name + R"(","components":)" +
                             json_text(document.root()["components"]) + "}";
  return Schema(schema).problems(Document::parse(json, {}));
}

TEST(Contract, ReportsFitTheirSchemas) {
  const Document document = openapi();
  const Value example = document.root()["components"]["schemas"]["ModelReport"]["examples"].at(0);
  EXPECT_THAT(check_component("ModelReport", json_text(example)), testing::IsEmpty());
  EXPECT_THAT(check_component("ModelReport", "{}"), testing::Not(testing::IsEmpty()));

  ModelBundle bundle;
  bundle.document = Blob(std::string(
      R"({"asset":{"version":"2.0"},"nodes":[{"camera":0}],"images":[{"uri":"gone.png"}],"materials":[{}],
      "cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}]})"));
  const std::string text =
      model_report_json(inspect_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline()));
  EXPECT_THAT(check_component("ModelReport", text), testing::IsEmpty()) << text;
  const Document report = Document::parse(text, {});
  EXPECT_EQ(report.root()["missingFiles"].at(0).text(), "gone.png");
  // The table of members says all that is written, and a report says all that the example says.
  const Value properties = document.root()["components"]["schemas"]["ModelReport"]["properties"];
  for (const auto& [key, member] : report.root().members()) EXPECT_TRUE(properties[key]) << key;
  for (const auto& [key, member] : example.members()) EXPECT_TRUE(report.root()[key]) << key;

  RenderReport render;
  render.stages = {{"draw", 1.5, {}}, {"bake", 0, "disk"}};
  render.notes = {{"image-missing", "/images/0", "is \xff missing"}};
  EXPECT_THAT(check_component("RenderReport", render_report_json(render)), testing::IsEmpty());
  for (const auto& [name, request] :
       document
           .root()["paths"]["/v1/inspect"]["post"]["requestBody"]["content"]["application/json"]["examples"]
           .members())
    EXPECT_THAT(check_component("InspectRequest", json_text(request["value"])), testing::IsEmpty()) << name;
}

TEST(Capabilities, FitTheirSchemaAndTellTheTables) {
  Capabilities capabilities;
  capabilities.version = {"1.2.3", "1.2.3+abc", "def", "llvmpipe", "1.2.3/def"};
  capabilities.request.max_side_px = 77;
  const std::string text = capabilities_json(capabilities);
  const Document document = Document::parse(text, {});
  const Value root = document.root();
  EXPECT_EQ(root["limits"]["maxSidePx"].integer(), 77);
  EXPECT_EQ(root["output"]["formats"].size(), kFormats.size());
  EXPECT_EQ(root["output"]["qualitySamples"]["reference"].integer(), 64);
  EXPECT_EQ(root["builtin"]["materialPresets"].size(), material_preset_names().size());
  EXPECT_EQ(root["builtin"]["environments"].size(), builtin_environment_names().size());
  EXPECT_EQ(root["gltfExtensions"].size(), supported_gltf_extensions().size());
  EXPECT_EQ(json_text(Document::parse(version_json(capabilities.version), {}).root()),
            json_text(root["version"]));

  const Document api_document = openapi();
  const Value schemas = api_document.root()["components"]["schemas"];
  for (const auto& [key, member] : schemas["Capabilities"]["properties"].members())
    EXPECT_TRUE(root[key]) << key;
  EXPECT_EQ(root.size(), schemas["Capabilities"]["properties"].size());
  EXPECT_THAT(check_against(schemas["Version"], version_json(capabilities.version)), testing::IsEmpty());
}

}  // namespace
}  // namespace furnace::api
