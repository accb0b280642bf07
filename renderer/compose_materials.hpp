// A request's materials over those of a scene, with their textures, and what meshes then need.
#pragma once

#include <map>
#include <set>
#include <string>

#include "renderer/compose.hpp"

namespace furnace {

// Threads: one. Owns: what it has used and added.
class MaterialComposer {
 public:
  // `scene` gets the images of the request's textures.
  MaterialComposer(const SceneSpec& spec, Scene& scene) : spec_(spec), scene_(scene) {}

  // What the request says of materials of this name, if anything, over `material`. Errors: kUnprocessable for a preset
  // that is not there.
  void apply(const std::string& name, Material& material);
  // Notes the materials of the request that were never applied.
  void note_unused();

 private:
  int add_image(const Blob& encoded, const std::string& pointer);

  const SceneSpec& spec_;
  Scene& scene_;
  std::map<ContentHash, int> images_;  // in scene_.images, by their bytes
  std::set<std::string> used_;
};

// Gives the meshes of `out` the UV sets and tangents that their materials need and they lack, with notes; such a mesh gets
// another key.
void complete_meshes(ComposedScene& out);

}  // namespace furnace
