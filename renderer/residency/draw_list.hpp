// Instances -> sorted draws with their exact shader features, and the buffers they read.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "renderer/gl/feature_set.hpp"
#include "renderer/residency/gpu_blocks.hpp"
#include "renderer/residency/residency.hpp"
#include "renderer/scene/framing.hpp"

namespace furnace {

struct GpuMaterial {
  std::array<GLuint, kTextureUses> textures{};
  std::array<GLuint, kTextureUses> samplers{};
  gl::FeatureSet features = 0;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  bool double_sided = false;
  bool layered = false;  // reads a LayerBlock
};

struct Draw {
  const GpuMesh* mesh = nullptr;
  const GpuOccluder* occluder = nullptr;  // of triangles where the environment casts shadows
  int source_mesh = 0;                    // index into PreparedScene::meshes
  int material = 0;                       // index into GpuScene::materials
  int block = 0;                          // index into draw_blocks
  gl::FeatureSet features = 0;
  bool mirrored = false;  // negative determinant: front faces wind the other way
  float distance = 0;     // m, eye to the centre of the bounds
  std::uint32_t key = 0;  // DrawBlock::key
  glm::mat4 world_from_model{1};

  bool seen_through() const { return (features & gl::kFeatureTransmission) != 0; }
};

// A scene on the GPU, ready to be drawn; its pointers live as long as the frame.
// Threads: the context's. Owns: its block buffers.
struct GpuScene {
  std::vector<Draw> deferred;  // opaque, masked and transmissive triangles, nearest first
  std::vector<Draw> strokes;   // opaque lines and points
  std::vector<Draw> blended;   // farthest first
  std::vector<GpuMaterial> materials;
  gl::Buffer draw_blocks, material_blocks, layer_blocks;
  GLintptr draw_stride = 0, material_stride = 0, layer_stride = 0;
  std::optional<float>
      nearest_glass_m;  // Draw::distance of the nearest surface that is seen through, if there is one
  const GpuEnvironment* environment = nullptr;
  const GpuTexture* sky = nullptr;         // the environment itself
  const GpuTexture* background = nullptr;  // what is seen of an environment; null for another background
  const GpuGroundShadow* ground_shadow = nullptr;
  const GpuTexture* lobe_tables = nullptr;
};

// Makes everything resident. False when a mesh or texture must be prepared first (evicted since it was looked up).
bool make_gpu_scene(gl::Context& context, Residency& residency, const PreparedScene& scene, const View& view,
                    GpuScene& out);

}  // namespace furnace
