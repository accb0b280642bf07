// RenderSpec -> everything decoded and baked, through byte-bounded CPU caches.
#pragma once

#include <memory>

#include "renderer/base/budget_cache.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/compose.hpp"
#include "renderer/renderer.hpp"
#include "renderer/residency/residency.hpp"

namespace furnace {

struct Preparation {
  PreparedScene scene;
  std::shared_ptr<const ComposedScene> composed;  // bounds and cameras for framing
  std::vector<Note> notes;
};

// Threads: any. Owns: the caches of parsed scenes and prepared environments.
class SceneStore {
 public:
  SceneStore(const RendererConfig& config, WorkerPool& pool, std::shared_ptr<ResidentKeys> resident);

  // Decodes what is neither cached nor on the GPU. Adds to decode_ms and bake_ms of `times`.
  // Errors: those of import, composition, decoding and baking, with pointers into the request or the model.
  Preparation prepare(const RenderSpec& spec, const Deadline& deadline, StageTimes& times);

 private:
  struct Environment {
    PreparedEnvironment prepared;
    std::vector<Note> notes;
  };

  std::shared_ptr<const ComposedScene> compose(const SceneSpec& spec, const Deadline& deadline, bool& hit);
  void prepare_textures(PreparedScene& out, const Scene& scene, std::vector<Note>& notes, bool& hit);
  std::shared_ptr<const Environment> environment(const EnvironmentSpec& spec, const Deadline& deadline,
                                                 StageTimes& times);

  const RendererConfig config_;
  WorkerPool& pool_;
  std::shared_ptr<ResidentKeys> resident_;
  BudgetCache<Scene> imports_;
  BudgetCache<ComposedScene> compositions_;
  BudgetCache<Environment> environments_;
};

}  // namespace furnace
