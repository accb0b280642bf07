// A request's scene from its parts: the imported model, built-in nodes and material overrides.
#pragma once

#include <vector>

#include "renderer/scene/render_spec.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

struct ComposedScene {
  Scene scene;
  Bounds bounds;  // world_bounds(scene)

  std::size_t byte_size() const { return scene.byte_size(); }
};

// `model` is the imported spec.model, or null. Pure. Errors: kUnprocessable with pointers under "/scene".
ComposedScene compose_scene(const SceneSpec& spec, const Scene* model);

}  // namespace furnace
