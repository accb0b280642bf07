// The one table of extensions that are read, each with the file that does it.
#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "renderer/scene/gltf_import.hpp"
#include "renderer/scene/gltf_read.hpp"

namespace furnace {

namespace {

constexpr std::array<std::string_view, 34> kSupportedExtensions{
    "EXT_mesh_gpu_instancing",              // gltf_instances.cpp
    "EXT_meshopt_compression",              // gltf_read_compression.cpp
    "EXT_texture_avif",                     // gltf_read_material.cpp
    "EXT_texture_webp",                     // gltf_read_material.cpp
    "KHR_draco_mesh_compression",           // gltf_draco.cpp
    "KHR_animation_pointer",                // gltf_properties.cpp
    "KHR_lights_punctual",                  // gltf_read_scene.cpp
    "KHR_materials_anisotropy",             // gltf_read_layers.cpp
    "KHR_materials_clearcoat",              // gltf_read_layers.cpp
    "KHR_materials_diffuse_transmission",   // gltf_read_layers.cpp
    "KHR_materials_dispersion",             // gltf_read_layers.cpp
    "KHR_materials_emissive_strength",      // gltf_read_material.cpp
    "KHR_materials_ior",                    // gltf_read_layers.cpp
    "KHR_materials_iridescence",            // gltf_read_layers.cpp
    "KHR_materials_pbrSpecularGlossiness",  // gltf_read_layers.cpp
    "KHR_materials_sheen",                  // gltf_read_layers.cpp
    "KHR_materials_specular",               // gltf_read_layers.cpp
    "KHR_materials_transmission",           // gltf_read_layers.cpp
    "KHR_materials_unlit",                  // gltf_read_material.cpp
    "KHR_materials_variants",               // gltf_read_scene.cpp
    "KHR_materials_volume",                 // gltf_read_layers.cpp
    "KHR_mesh_quantization",                // gltf_primitive.cpp
    "KHR_meshopt_compression",              // gltf_read_compression.cpp
    "KHR_node_visibility",                  // gltf_read_scene.cpp
    "KHR_texture_basisu",                   // gltf_read_material.cpp
    "KHR_texture_transform",                // gltf_read_material.cpp
    // No picture needs these: what things are, where polygons were, what a pointer may do.
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "FB_ngon_encoding",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_xmp",
    "KHR_xmp_json_ld",
};

// A way down a document; its text is only made for what is found.
struct Step {
  std::string_view key;   // of an object
  std::size_t index = 0;  // of an array, whose steps have no key
};

std::string pointer_of(const std::vector<Step>& way) {
  std::string pointer;
  for (const Step& step : way)
    pointer =
        step.key.empty() ? pointer + "/" + std::to_string(step.index) : pointer_below(pointer, step.key);
  return pointer;
}

// Depth is the document's, which parse_json bounds.
void find_undeclared(const Json& value, const std::set<std::string_view>& known, std::vector<Step>& way,
                     std::map<std::string, std::string>& found) {
  const auto below = [&](const Json& member, const Step& step) {
    if (!member.is_structured()) return;
    way.push_back(step);
    find_undeclared(member, known, way, found);
    way.pop_back();
  };
  if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) below(value[i], {{}, i});
    return;
  }
  for (auto member = value.begin(); member != value.end(); ++member) {
    if (member.key() == "extras") continue;
    if (member.key() == "extensions" && member->is_object())
      for (auto extension = member->begin(); extension != member->end(); ++extension)
        if (found.size() < kMostUndeclared && !known.contains(extension.key()))
          found.try_emplace(extension.key(),
                            pointer_below(pointer_below(pointer_of(way), "extensions"), extension.key()));
    below(*member, {member.key(), 0});
  }
}

}  // namespace

std::vector<std::string_view> supported_gltf_extensions() {
  return {kSupportedExtensions.begin(), kSupportedExtensions.end()};
}

std::map<std::string, std::string> undeclared_extensions(const Json& root) {
  std::set<std::string_view> known(kSupportedExtensions.begin(), kSupportedExtensions.end());
  const std::vector<std::string> used = JsonObject(root, "").strings("extensionsUsed");
  known.insert(used.begin(), used.end());
  std::map<std::string, std::string> found;
  std::vector<Step> way;
  find_undeclared(root, known, way, found);
  return found;
}

}  // namespace furnace
