// What a glTF document tells that no picture needs: where it comes from, names, declared bounds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/gltf_document.hpp"

namespace furnace {

struct GltfAsset {
  std::string version, generator, copyright;
};

// As declared for an accessor, as many as it has components; empty: not declared, or not so many numbers.
struct GltfRange {
  std::vector<double> min, max;
};

// Lists are as long as those of the document that they are about.
struct GltfAbout {
  GltfAsset asset;
  std::vector<std::string> extensions_required;
  std::vector<std::string> extensions_undeclared;  // neither supported nor in extensionsUsed, sorted
  std::vector<std::string> scene_names, skin_names, texture_names, image_names, image_media_types;
  std::vector<GltfRange> ranges;                              // by accessor
  std::vector<std::vector<std::string>> material_extensions;  // by material, sorted
  std::vector<int> extension_views;  // bufferViews that extensions name by a member "bufferView"
};

// `document` is that of the same bytes. Reads what is there and passes over what has a wrong type, since a render does
// not ask for it either. Errors: those of JSON.
GltfAbout read_gltf_about(const Blob& bytes, const GltfDocument& document);

}  // namespace furnace
