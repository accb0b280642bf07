// What the ground's shadow is drawn of.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "renderer/base/worker_pool.hpp"
#include "renderer/residency/residency.hpp"
#include "renderer/scene/render_spec.hpp"

namespace furnace {

glm::dvec3 vector_of(const std::array<double, 3>& v);
glm::dmat3 turned_about_y(double angle_rad);
// Directions that stand for the environment, as it shines in the scene.
std::vector<LightDirection> in_world(std::vector<LightDirection> sources, const PreparedScene& scene,
                                     double rotation_rad);

// Which of how many parts of the light's directions a moment takes: the mean of all has all of them.
struct LightPart {
  int index = 0, count = 1;
};

// One ground under all the scenes of a picture, with the shadow of each.
// Threads: one. Owns: what stands for the meshes in their shadows.
class GroundWork {
 public:
  // All of these outlive it. `samples`: sub-frames of the picture.
  GroundWork(const GroundSpec& wanted, double rotation_rad, int samples, const ResidentKeys& resident,
             WorkerPool& pool)
      : wanted_(wanted), rotation_rad_(rotation_rad), samples_(samples), resident_(resident), pool_(pool) {}

  // Of every scene, before anything is asked.
  void add_bounds(const Bounds& bounds) { bounds_.add(bounds); }

  PreparedGround without_shadow() const;
  // Its shadow if one is wanted. `scene_key`: hash of the description of `scene`.
  PreparedGround with_shadow(const ContentHash& scene_key, const PreparedScene& scene, LightPart part);

 private:
  using Indices = std::shared_ptr<const std::vector<std::uint32_t>>;
  std::vector<Indices> occluders_of(const std::vector<PreparedMesh>& meshes);

  const GroundSpec& wanted_;
  const double rotation_rad_;
  const int samples_;
  const ResidentKeys& resident_;
  WorkerPool& pool_;
  Bounds bounds_;
  std::map<ContentHash, Indices> occluders_;  // by key of the mesh
};

}  // namespace furnace
