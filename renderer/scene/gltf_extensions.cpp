// The one table of extensions that are read, each with the file that does it.
#include <array>

#include "renderer/scene/gltf_import.hpp"

namespace furnace {

namespace {

constexpr std::array<std::string_view, 26> kSupportedExtensions{
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
};

}  // namespace

std::vector<std::string_view> supported_gltf_extensions() {
  return {kSupportedExtensions.begin(), kSupportedExtensions.end()};
}

}  // namespace furnace
