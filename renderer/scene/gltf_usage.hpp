// Which parts of a glTF document something leads to.
#pragma once

#include <vector>

#include "renderer/scene/gltf_about.hpp"

namespace furnace {

// By index.
struct GltfUsage {
  std::vector<bool> nodes, meshes, materials, textures, images, skins, cameras, accessors, buffer_views;
};

// From every scene (without scenes, from every root node), the joints of skins that are used, and every animation.
GltfUsage gltf_usage(const GltfDocument& document, const GltfAbout& about);

}  // namespace furnace
