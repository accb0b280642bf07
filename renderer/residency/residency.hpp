// What is on one context's GPU: meshes, textures and environments by key, within a budget, evicted between frames.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "renderer/gl/texture.hpp"
#include "renderer/residency/gpu_mesh.hpp"
#include "renderer/residency/prepared_scene.hpp"

namespace furnace {

struct GpuTexture {
  gl::Texture texture;
  Extent extent;
  std::size_t bytes = 0;
  float lowest_green = 0;  // PreparedTexture::lowest_green
};

// Triangles over the vertices of a mesh.
struct GpuOccluder {
  gl::Buffer indices;
  GLsizei count = 0;
  std::size_t bytes = 0;
};

struct GpuEnvironment {
  gl::Texture atlas;
  std::size_t bytes = 0;
};

// A rectangle of the ground, world metres.
struct GroundRectangle {
  glm::dvec2 low{0}, high{0};  // (x, z)
};

// How much of the environment's light reaches the ground, of each colour: rows along +z, columns along +x.
struct GpuGroundShadow {
  gl::Texture texture;  // RGBA32F with all mip levels, [0, 1]
  GroundRectangle rectangle;
  std::size_t bytes = 0;
};

// The keys that are resident, for the CPU side to skip decoding, and their bytes; a snapshot that may be old by the time it is
// used.
// Threads: any. Owns: the set.
class ResidentKeys {
 public:
  bool contains(const ContentHash& key) const;
  void insert(const ContentHash& key, std::int64_t bytes);
  void erase(const ContentHash& key, std::int64_t bytes);
  std::int64_t bytes() const;

 private:
  mutable std::mutex mutex_;
  std::unordered_set<ContentHash> keys_;
  std::int64_t bytes_ = 0;
};

// Least recently used first out; what the current frame has asked for stays.
template <class Value>
class GpuCache {
 public:
  GpuCache(std::int64_t& total_bytes, ResidentKeys& keys) : total_bytes_(total_bytes), keys_(keys) {}

  const Value* find(const ContentHash& key, std::uint64_t frame) {
    const auto at = entries_.find(key);
    if (at == entries_.end()) return nullptr;
    at->second.frame = frame;
    return &at->second.value;
  }
  const Value* insert(const ContentHash& key, std::uint64_t frame, Value value) {
    total_bytes_ += std::int64_t(value.bytes);
    keys_.insert(key, std::int64_t(value.bytes));
    return &entries_.insert_or_assign(key, Entry{std::move(value), frame}).first->second.value;
  }
  // The oldest entry that `frame` does not use: its last frame, or `frame` when there is none.
  std::uint64_t oldest(std::uint64_t frame) const {
    std::uint64_t oldest = frame;
    for (const auto& [key, entry] : entries_) oldest = std::min(oldest, entry.frame);
    return oldest;
  }
  void evict(std::uint64_t last_used_in) {
    std::erase_if(entries_, [&](const auto& item) {
      return item.second.frame == last_used_in && (forget(item.first, item.second), true);
    });
  }
  void clear() {
    for (const auto& [key, entry] : entries_) forget(key, entry);
    entries_.clear();
  }

 private:
  struct Entry {
    Value value;
    std::uint64_t frame = 0;
  };
  void forget(const ContentHash& key, const Entry& entry) {
    total_bytes_ -= std::int64_t(entry.value.bytes);
    keys_.erase(key, std::int64_t(entry.value.bytes));
  }

  std::int64_t& total_bytes_;
  ResidentKeys& keys_;
  std::unordered_map<ContentHash, Entry> entries_;
};

// Threads: the context's, but for keys(). Owns: every GL object it hands out.
class Residency {
 public:
  Residency(gl::Context& context, std::int64_t budget_bytes, std::shared_ptr<ResidentKeys> keys);
  ~Residency();

  // Starts a frame: evicts down to the budget; pointers handed out from here on live until the next call.
  void begin_frame();

  // Null when it is neither resident nor packed, or decoded: the caller must prepare it and come again.
  const GpuMesh* mesh(const PreparedMesh& mesh);
  const GpuOccluder* occluder(const PreparedMesh& mesh);
  const GpuTexture* texture(const PreparedTexture& texture);
  const GpuTexture* sky(const PreparedSky& sky);
  const GpuEnvironment* environment(const PreparedEnvironment& environment);
  // An array of kDfgTableSize a side: DFG, LTC, then a profile for each light that has one, in their order.
  const GpuTexture* lobe_tables(const std::vector<Light>& lights);
  // Drawn, not uploaded: the frame makes what is not found.
  const GpuGroundShadow* find_ground_shadow(const ContentHash& key) {
    return ground_shadows_.find(key, frame_);
  }
  const GpuGroundShadow* keep_ground_shadow(const ContentHash& key, GpuGroundShadow shadow);

  GLuint neutral_texture() const { return neutral_.id(); }
  gl::SamplerCache& samplers() { return samplers_; }
  bool uploaded() const { return uploaded_; }  // anything since begin_frame()

 private:
  gl::Context& context_;
  std::int64_t budget_bytes_;
  std::shared_ptr<ResidentKeys> keys_;
  std::int64_t total_bytes_ = 0;
  std::uint64_t frame_ = 0;
  bool uploaded_ = false;
  GpuCache<GpuMesh> meshes_;
  GpuCache<GpuOccluder> occluders_;
  GpuCache<GpuTexture> textures_;
  GpuCache<GpuTexture> skies_, lobe_tables_;
  GpuCache<GpuEnvironment> environments_;
  GpuCache<GpuGroundShadow> ground_shadows_;
  gl::Texture neutral_;  // 1x1, white: every absent map reads 1
  gl::SamplerCache samplers_;
};

}  // namespace furnace
