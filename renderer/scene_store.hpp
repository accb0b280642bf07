// RenderSpec -> everything decoded and baked, through byte-bounded CPU caches.
#pragma once

#include <memory>

#include "renderer/base/budget_cache.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/compose.hpp"
#include "renderer/environment_store.hpp"
#include "renderer/moments.hpp"
#include "renderer/renderer.hpp"
#include "renderer/residency/residency.hpp"
#include "renderer/texture_notes.hpp"

namespace furnace {

struct PreparedMoment {
  std::shared_ptr<const ComposedScene> composed;
  double offset_s = 0;  // from the shutter's middle
  PreparedScene scene;  // its sky_sums are those of the middle
};

struct Preparation {
  PreparedScene scene;                            // in the middle of the shutter
  std::shared_ptr<const ComposedScene> composed;  // bounds and cameras for framing
  std::vector<PreparedMoment> moments;            // of the open shutter; empty where nothing moves
  std::vector<Note> notes;
};

// Threads: any. Owns: the caches of parsed and composed scenes, and the environments.
class SceneStore {
 public:
  // `pool` and `decoder` outlive it.
  SceneStore(const RendererConfig& config, WorkerPool& pool, Decoder& decoder);

  // Decodes what is neither cached nor `resident` on the GPU. Adds to decode_ms and bake_ms of `times`.
  // Errors: those of import, composition, decoding and baking, with pointers into the request or the model.
  Preparation prepare(const RenderSpec& spec, const ResidentKeys& resident, const Deadline& deadline,
                      const TellStage& tell, StageTimes& times);

  // Imports and composes what is not cached, decodes nothing. Errors: those of import and composition.
  std::shared_ptr<const ComposedScene> composed(const SceneSpec& spec, const Deadline& deadline);
  // The same, with all that is anywhere else while the shutter is open.
  Scene swept(const RenderSpec& spec, const Deadline& deadline);

  // Bakes an environment as a render would, for its report. Errors: those of decoding and baking.
  EnvironmentAnswer environment_summary(const EnvironmentSpec& spec, const Deadline& deadline);
  CacheStats baked_stats() const { return environments_.baked_stats(); }

 private:
  std::shared_ptr<const Scene> imported(const SceneSpec& spec, const Deadline& deadline);
  std::shared_ptr<const ComposedScene> compose(const SceneSpec& spec, const Deadline& deadline, bool& hit);
  std::shared_ptr<const ComposedMoments> composed_moments(const RenderSpec& spec, const ComposedScene& middle,
                                                          const Deadline& deadline, bool& hit);
  void add_moments(const RenderSpec& spec, const Deadline& deadline, bool& hit, Preparation& out);
  // Of all scenes, each once.
  std::vector<PreparedMesh> prepare_meshes(const ResidentKeys& resident, const Preparation& out);
  void prepare_occluders(const ResidentKeys& resident, std::vector<PreparedMesh>& meshes);
  void prepare_textures(const ResidentKeys& resident, const Deadline& deadline, bool& hit, Preparation& out);
  void prepare_environment(const RenderSpec& spec, const Deadline& deadline, const TellStage& tell,
                           StageTimes& times, Preparation& out);
  void prepare_grounds(const RenderSpec& spec, const ResidentKeys& resident, StageTimes& times,
                       Preparation& out);

  const RendererConfig config_;
  WorkerPool& pool_;
  Decoder& decoder_;
  BudgetCache<Scene> imports_;
  BudgetCache<ComposedScene> compositions_;
  BudgetCache<ComposedMoments> moments_;
  EnvironmentStore environments_;
  TextureNotes texture_notes_;
};

}  // namespace furnace
