#include "api/capabilities.hpp"

#include "renderer/scene/procedural.hpp"

#include <nlohmann/json.hpp>

namespace furnace::api {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson prefixed_names(const std::vector<std::string_view>& names) {
  OrderedJson list = OrderedJson::array();
  for (const std::string_view name : names) list.push_back("builtin:" + std::string(name));
  return list;
}

OrderedJson version_members(const VersionInfo& version) {
  return {{"name", "furnace"},          {"version", version.version}, {"build", version.build},
          {"shaders", version.shaders}, {"gl", version.gl},           {"fingerprint", version.fingerprint}};
}

OrderedJson limits(const Capabilities& c) {
  return {{"maxSidePx", c.request.max_side_px},
          {"maxAreaPx", c.request.max_area_px},
          {"maxSamples", c.request.max_samples},
          {"maxLayerBytes", c.request.max_layer_bytes},
          {"maxFrames", c.request.max_frames},
          {"maxSequencePx", c.request.max_sequence_px},
          {"maxRequestJsonBytes", c.request.max_json_bytes},
          {"maxRequestJsonDepth", c.request.max_json_depth},
          {"maxBodyBytes", c.max_body_bytes},
          {"maxTexturePx", c.max_texture_px},
          {"maxTriangles", c.import.max_triangles},
          {"maxVertices", c.import.max_vertices},
          {"maxNodes", c.import.max_nodes},
          {"maxNodeDepth", c.import.max_node_depth},
          {"maxModelJsonBytes", c.import.max_json_bytes},
          {"maxModelBufferBytes", c.import.max_buffer_bytes}};
}

OrderedJson qualities() {
  OrderedJson samples = OrderedJson::object();
  for (const QualityLevel& level : kQualityLevels) samples[std::string(level.name)] = level.samples;
  return samples;
}

OrderedJson film_layers() {
  OrderedJson list = OrderedJson::array();
  for (const FilmLayerRow& row : kFilmLayers)
    list.push_back({{"name", row.name}, {"channels", row.channels}});
  return list;
}

OrderedJson formats() {
  OrderedJson list = OrderedJson::array();
  for (const FormatRow& row : kFormats) list.push_back({{"format", row.name}, {"mediaType", row.media_type}});
  return list;
}

}  // namespace

std::string version_json(const VersionInfo& version) {
  return version_members(version).dump(2, ' ', false, OrderedJson::error_handler_t::replace);
}

std::string capabilities_json(const Capabilities& capabilities) {
  const OrderedJson document = {
      {"version", version_members(capabilities.version)},
      {"softwareGl", capabilities.software_gl},
      {"remoteFiles", capabilities.remote_files},
      {"webhooks", capabilities.webhooks},
      {"output", {{"formats", formats()}, {"qualitySamples", qualities()}, {"layers", film_layers()}}},
      {"limits", limits(capabilities)},
      {"gltfExtensions", supported_gltf_extensions()},
      {"builtin",
       {{"meshes", prefixed_names(builtin_mesh_names())},
        {"environments", prefixed_names(builtin_environment_names())},
        {"materialPresets", material_preset_names()}}},
  };
  return document.dump(2, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace furnace::api
