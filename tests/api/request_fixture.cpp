#include "tests/api/request_fixture.hpp"

#include "api/contract.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace furnace::api {
namespace {

constexpr FieldRow kFieldRows[] = {
    {"/scene/model", R"({"scene":{"model":@}})", R"("builtin:cube")", R"("part:model.gltf")"},
    {"/scene/gltfScene", R"({"scene":{"model":"part:model.gltf","gltfScene":@}})", "0", "1"},
    {"/scene/nodes/mesh", R"({"scene":{"nodes":[{"mesh":@}]}})", R"("builtin:cube")", R"("builtin:plane")"},
    {"/scene/nodes/material", R"({"scene":{"nodes":[{"mesh":"builtin:cube","material":@}]}})", R"("gold")",
     R"("chrome")"},
    {"/scene/nodes/translation", R"({"scene":{"nodes":[{"mesh":"builtin:cube","translation":@}]}})",
     "[1,2,3]", "[1,2,4]"},
    {"/scene/nodes/rotation", R"({"scene":{"nodes":[{"mesh":"builtin:cube","rotation":@}]}})", "[0,1,0,0]",
     "[0,0,1,0]"},
    {"/scene/nodes/scale", R"({"scene":{"nodes":[{"mesh":"builtin:cube","scale":@}]}})", "[1,2,3]",
     "[3,2,1]"},
    {"/scene/materials", R"({"scene":{"materials":{"gold":@}}})", R"("chrome")", R"("silver")"},
    {"/scene/materials/preset", R"({"scene":{"materials":{"m":{"preset":@}}}})", R"("chrome")",
     R"("silver")"},
    {"/scene/materials/baseColor", R"({"scene":{"materials":{"m":{"baseColor":@}}}})", "[1,0,0]",
     "[1,0,0,0.5]"},
    {"/scene/materials/metallic", R"({"scene":{"materials":{"m":{"metallic":@}}}})", "0", "1"},
    {"/scene/materials/roughness", R"({"scene":{"materials":{"m":{"roughness":@}}}})", "0", "1"},
    {"/scene/materials/emissive", R"({"scene":{"materials":{"m":{"emissive":@}}}})", "[0,0,0]", "[0,0,7]"},
    {"/scene/materials/emissiveStrength", R"({"scene":{"materials":{"m":{"emissiveStrength":@}}}})", "1",
     "2"},
    {"/scene/materials/normalScale", R"({"scene":{"materials":{"m":{"normalScale":@}}}})", "1", "-1"},
    {"/scene/materials/occlusionStrength", R"({"scene":{"materials":{"m":{"occlusionStrength":@}}}})", "0",
     "1"},
    {"/scene/materials/alphaMode", R"({"scene":{"materials":{"m":{"alphaMode":@}}}})", R"("MASK")",
     R"("BLEND")"},
    {"/scene/materials/alphaCutoff", R"({"scene":{"materials":{"m":{"alphaMode":"MASK","alphaCutoff":@}}}})",
     "0.25", "0.75"},
    {"/scene/materials/doubleSided", R"({"scene":{"materials":{"m":{"doubleSided":@}}}})", "true", "false"},
    {"/scene/materials/unlit", R"({"scene":{"materials":{"m":{"unlit":@}}}})", "true", "false"},
    {"/environment/map", R"({"environment":{"map":@}})", R"("builtin:furnace")", R"("part:sky.hdr")"},
    {"/map:color/color", R"({"environment":{"map":{"color":@}}})", "[1,1,1]", "[1,1,2]"},
    {"/map:gradient/stops/elevationDegrees",
     R"({"environment":{"map":{"type":"gradient","stops":[{"color":[1,1,1],"elevationDegrees":@},{"elevationDegrees":90,"color":[2,2,2]}]}}})",
     "0", "10"},
    {"/map:gradient/stops/color",
     R"({"environment":{"map":{"type":"gradient","stops":[{"elevationDegrees":0,"color":@},{"elevationDegrees":90,"color":[2,2,2]}]}}})",
     "[1,1,1]", "[1,0,1]"},
    {"/map:gradient/interpolation", R"({"environment":{"map":{"type":"gradient","interpolation":@}}})",
     R"("linear")", R"("smooth")"},
    {"/map:overcast/zenithLuminance", R"({"environment":{"map":{"type":"overcast","zenithLuminance":@}}})",
     "1", "2"},
    {"/map:overcast/groundAlbedo", R"({"environment":{"map":{"type":"overcast","groundAlbedo":@}}})", "0",
     "1"},
    {"/map:clear-sky/turbidity", R"({"environment":{"map":{"type":"clear-sky","turbidity":@}}})", "2", "3"},
    {"/map:clear-sky/groundAlbedo", R"({"environment":{"map":{"type":"clear-sky","groundAlbedo":@}}})", "0",
     "1"},
    {"/map:clear-sky/elevationDegrees",
     R"({"environment":{"map":{"type":"clear-sky","elevationDegrees":@}}})", "10", "20"},
    {"/map:clear-sky/azimuthDegrees", R"({"environment":{"map":{"type":"clear-sky","azimuthDegrees":@}}})",
     "10", "20"},
    {"/map:clear-sky/sunDisc", R"({"environment":{"map":{"type":"clear-sky","sunDisc":@}}})", "true",
     "false"},
    {"/map:clear-sky/sunRadiusDegrees",
     R"({"environment":{"map":{"type":"clear-sky","sunRadiusDegrees":@}}})", "1", "2"},
    {"/map:clear-sky/calibration", R"({"environment":{"map":{"type":"clear-sky","calibration":@}}})",
     R"("white-card")", R"("physical")"},
    {"/map:clear-sky/dateTime",
     R"({"environment":{"map":{"type":"clear-sky","latitudeDegrees":0,"longitudeDegrees":0,"dateTime":@}}})",
     R"("2026-03-20T12:00Z")", R"("2026-03-20T13:00Z")"},
    {"/map:clear-sky/latitudeDegrees",
     R"({"environment":{"map":{"type":"clear-sky","dateTime":"2026-03-20T12:00:00Z","longitudeDegrees":0,"latitudeDegrees":@}}})",
     "10", "20"},
    {"/map:clear-sky/longitudeDegrees",
     R"({"environment":{"map":{"type":"clear-sky","dateTime":"2026-03-20T12:00:00Z","latitudeDegrees":86,"longitudeDegrees":@}}})",
     "10", "20"},
    {"/map:clear-sky/northDegrees",
     R"({"environment":{"map":{"type":"clear-sky","dateTime":"2026-03-20T12:00:00Z","latitudeDegrees":10,"longitudeDegrees":0,"northDegrees":@}}})",
     "10", "20"},
    {"/map:studio/lights/shape", R"({"environment":{"map":{"type":"studio","lights":[{"shape":@}]}}})",
     R"("rectangle")", R"("disc")"},
    {"/map:studio/lights/azimuthDegrees",
     R"({"environment":{"map":{"type":"studio","lights":[{"azimuthDegrees":@}]}}})", "10", "20"},
    {"/map:studio/lights/elevationDegrees",
     R"({"environment":{"map":{"type":"studio","lights":[{"elevationDegrees":@}]}}})", "10", "20"},
    {"/map:studio/lights/rollDegrees",
     R"({"environment":{"map":{"type":"studio","lights":[{"rollDegrees":@}]}}})", "10", "20"},
    {"/map:studio/lights/widthDegrees",
     R"({"environment":{"map":{"type":"studio","lights":[{"widthDegrees":@}]}}})", "10", "20"},
    {"/map:studio/lights/heightDegrees",
     R"({"environment":{"map":{"type":"studio","lights":[{"heightDegrees":@}]}}})", "10", "20"},
    {"/map:studio/lights/color", R"({"environment":{"map":{"type":"studio","lights":[{"color":@}]}}})",
     "[1,1,1]", "[1,0,1]"},
    {"/map:studio/lights/luminance",
     R"({"environment":{"map":{"type":"studio","lights":[{"luminance":@}]}}})", "1", "2"},
    {"/map:studio/lights/feather", R"({"environment":{"map":{"type":"studio","lights":[{"feather":@}]}}})",
     "0", "1"},
    {"/map:studio/lights/hotspot", R"({"environment":{"map":{"type":"studio","lights":[{"hotspot":@}]}}})",
     "1", "2"},
    {"/map:studio/room/stops/elevationDegrees",
     R"({"environment":{"map":{"type":"studio","room":{"stops":[{"color":[1,1,1],"elevationDegrees":@},{"elevationDegrees":90,"color":[2,2,2]}]}}}})",
     "0", "10"},
    {"/map:studio/room/stops/color",
     R"({"environment":{"map":{"type":"studio","room":{"stops":[{"elevationDegrees":0,"color":@},{"elevationDegrees":90,"color":[2,2,2]}]}}}})",
     "[1,1,1]", "[1,0,1]"},
    {"/map:studio/room/interpolation",
     R"({"environment":{"map":{"type":"studio","room":{"stops":[{"elevationDegrees":0,"color":[1,1,1]},{"elevationDegrees":90,"color":[2,2,2]}],"interpolation":@}}}})",
     R"("linear")", R"("smooth")"},
    {"/environment/rotationDegrees", R"({"environment":{"rotationDegrees":@}})", "0", "90"},
    {"/environment/intensity", R"({"environment":{"intensity":@}})", "1", "2"},
    {"/scene/lights/type", R"({"scene":{"lights":[{"type":@}]}})", R"("point")", R"("spot")"},
    {"/scene/lights/name", R"({"scene":{"lights":[{"type":"point","name":@}]}})", R"("a")", R"("b")"},
    {"/scene/lights/color", R"({"scene":{"lights":[{"type":"point","color":@}]}})", R"([1,1,1])",
     R"([1,0,1])"},
    {"/scene/lights/illuminanceLux", R"({"scene":{"lights":[{"type":"directional","illuminanceLux":@}]}})",
     R"(1)", R"(2)"},
    {"/scene/lights/intensityCandela", R"({"scene":{"lights":[{"type":"point","intensityCandela":@}]}})",
     R"(10)", R"(20)"},
    {"/scene/lights/fluxLumen", R"({"scene":{"lights":[{"type":"spot","fluxLumen":@}]}})", R"(100)",
     R"(200)"},
    {"/scene/lights/position", R"({"scene":{"lights":[{"type":"spot","position":@}]}})", R"([0,0,0])",
     R"([0,1,0])"},
    {"/scene/lights/direction", R"({"scene":{"lights":[{"type":"spot","direction":@}]}})", R"([0,-1,0])",
     R"([1,0,0])"},
    {"/scene/lights/innerConeDegrees",
     R"({"scene":{"lights":[{"type":"spot","outerConeDegrees":90,"innerConeDegrees":@}]}})", R"(0)", R"(10)"},
    {"/scene/lights/outerConeDegrees", R"({"scene":{"lights":[{"type":"spot","outerConeDegrees":@}]}})",
     R"(45)", R"(50)"},
    {"/scene/lights/rangeMetres", R"({"scene":{"lights":[{"type":"point","rangeMetres":@}]}})", R"(2)",
     R"(3)"},
    {"/scene/lights/radiusMetres", R"({"scene":{"lights":[{"type":"point","radiusMetres":@}]}})", R"(0)",
     R"(0.1)"},
    {"/scene/lights/angularRadiusDegrees",
     R"({"scene":{"lights":[{"type":"directional","angularRadiusDegrees":@}]}})", R"(0)", R"(1)"},
    {"/scene/lights/shadow", R"({"scene":{"lights":[{"type":"point","shadow":@}]}})", R"(true)", R"(false)"},
    {"/scene/modelLights", R"({"scene":{"modelLights":@}})", "true", "false"},
    {"/environment/illuminanceLux", R"({"environment":{"illuminanceLux":@}})", "1000", "2000"},
    {"/environment/sun", R"({"environment":{"sun":@}})", R"("keep")", R"("extract")"},
    {"/environment/visibility", R"({"environment":{"visibility":@}})", R"("on")", R"("off")"},
    {"/environment/background/map", R"({"environment":{"background":{"map":@}}})", R"("builtin:clear-sky")",
     R"("part:sky.hdr")"},
    {"/environment/background/rotationDegrees", R"({"environment":{"background":{"rotationDegrees":@}}})",
     "0", "30"},
    {"/environment/background/intensity", R"({"environment":{"background":{"intensity":@}}})", "1", "0.5"},
    {"/environment/background/blurDegrees", R"({"environment":{"background":{"blurDegrees":@}}})", "0", "8"},
    {"/environment/background/top", R"({"environment":{"background":{"type":"gradient","top":@}}})",
     "[1,1,1]", "[1,0,1]"},
    {"/environment/background/bottom", R"({"environment":{"background":{"type":"gradient","bottom":@}}})",
     "[0,0,0]", "[1,0,1]"},
    {"/environment/ground/shadow", R"({"environment":{"ground":{"shadow":@}}})", "true", "false"},
    {"/environment/ground/shadowStrength", R"({"environment":{"ground":{"shadowStrength":@}}})", "1", "0.5"},
    {"/environment/ground/levelMetres", R"({"environment":{"ground":{"levelMetres":@}}})", "0", "-1"},
    {"/environment/ground/projection/heightMetres",
     R"({"environment":{"ground":{"projection":{"radiusMetres":500000,"heightMetres":@}}}})", "1.6", "2"},
    {"/environment/ground/projection/radiusMetres",
     R"({"environment":{"ground":{"projection":{"heightMetres":0.0001,"radiusMetres":@}}}})", "10", "20"},
    {"/environment/background/type", R"({"environment":{"background":{"type":@}}})", R"("color")",
     R"("transparent")"},
    {"/environment/background/color", R"({"environment":{"background":{"type":"color","color":@}}})",
     "[0,0,0]", "[0,1,0]"},
    {"/camera/orbit/azimuthDegrees", R"({"camera":{"orbit":{"azimuthDegrees":@}}})", "0", "90"},
    {"/camera/orbit/elevationDegrees", R"({"camera":{"orbit":{"elevationDegrees":@}}})", "0", "45"},
    {"/camera/orbit/fit", R"({"camera":{"orbit":{"fit":@}}})", "1", "2"},
    {"/camera/orbit/orthographic", R"({"camera":{"orbit":{"orthographic":@}}})", "false", "true"},
    {"/camera/lookAt/eye", R"({"camera":{"lookAt":{"eye":@}}})", "[1,2,3]", "[1,2,4]"},
    {"/camera/lookAt/target", R"({"camera":{"lookAt":{"eye":[1,2,3],"target":@}}})", "[0,0,0]", "[0,1,0]"},
    {"/camera/lookAt/up", R"({"camera":{"lookAt":{"eye":[1,2,3],"up":@}}})", "[0,1,0]", "[0,0,1]"},
    {"/camera/gltf", R"({"camera":{"gltf":@}})", "1", R"("front")"},
    {"/camera/fovYDegrees", R"({"camera":{"fovYDegrees":@}})", "20", "40"},
    {"/camera/exposureEv", R"({"camera":{"exposureEv":@}})", "0", "-1.5"},
    {"/camera/ev100", R"({"camera":{"ev100":@}})", "0", "15"},
    {"/camera/aperture", R"({"camera":{"shutterSeconds":0.01,"aperture":@}})", "8", "5.6"},
    {"/camera/shutterSeconds", R"({"camera":{"aperture":8,"shutterSeconds":@}})", "0.01", "0.02"},
    {"/camera/iso", R"({"camera":{"aperture":8,"shutterSeconds":0.01,"iso":@}})", "100", "400"},
    {"/camera/autoExposure", R"({"camera":{"autoExposure":@}})", "false", "true"},
    {"/output/width", R"({"output":{"width":@}})", "64", "65"},
    {"/output/height", R"({"output":{"height":@}})", "64", "65"},
    {"/output/format", R"({"output":{"format":@}})", R"("png")", R"("exr")"},
    {"/output/exrType", R"({"output":{"format":"exr","exrType":@}})", R"("half")", R"("float")"},
    {"/output/bitDepth", R"({"output":{"bitDepth":@}})", "8", "16"},
    {"/output/compressionQuality", R"({"output":{"format":"jpeg","compressionQuality":@}})", "90", "75"},
    {"/output/lossless", R"({"output":{"format":"webp","lossless":@}})", "false", "true"},
    {"/output/exrCompression", R"({"output":{"format":"exr","exrCompression":@}})", R"("none")", R"("dwaa")"},
    {"/output/toneMap", R"({"output":{"toneMap":@}})", R"("linear")", R"("none")"},
    {"/output/whiteBalanceKelvin", R"({"output":{"whiteBalanceKelvin":@}})", "6504", "2856"},
    {"/output/whiteBalanceTint", R"({"output":{"whiteBalanceTint":@}})", "0", "10"},
    {"/output/contrast", R"({"output":{"contrast":@}})", "1", "1.1"},
    {"/output/saturation", R"({"output":{"saturation":@}})", "1", "0"},
    {"/output/quality", R"({"output":{"quality":@}})", R"("draft")", R"("high")"},
    {"/output/samples", R"({"output":{"samples":@}})", "2", "3"},
    {"/strict", R"({"strict":@})", "true", "false"},
};

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
  parts["sky.hdr"] = Blob("#?RADIANCE\n");
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
  return {1 << 20, std::int64_t{1} << 40, 1 << 20, 64, std::int64_t{1} << 24};
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

std::span<const FieldRow> field_rows() {
  return kFieldRows;
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
