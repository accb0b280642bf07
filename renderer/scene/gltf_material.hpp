// The document's materials and images as the scene's: only what is drawn, each once, in the order of first
// use.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_notes.hpp"

namespace furnace {

// Threads: one. Owns: nothing; fills scene.materials and scene.images.
class GltfMaterials {
 public:
  GltfMaterials(const GltfDocument& document, const GltfData& data, const ModelBundle& bundle, Scene& scene,
                GltfNotes& notes)
      : document_(document), data_(data), bundle_(bundle), scene_(scene), notes_(notes) {}

  // The index in scene.materials of a document's material, or of the default one.
  int scene_material(std::optional<int> material);

 private:
  Material convert(const GltfMaterial& material);
  std::optional<TextureSlot> convert(const std::optional<GltfTextureRef>& ref);
  std::optional<int> scene_image(int image);
  std::optional<Blob> find_image(int image);

  const GltfDocument& document_;
  const GltfData& data_;
  const ModelBundle& bundle_;
  Scene& scene_;
  GltfNotes& notes_;
  std::map<int, int> materials_;              // -1: the default
  std::map<int, std::optional<int>> images_;  // none: could not be used
};

}  // namespace furnace
