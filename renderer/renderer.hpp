// The facade: a RenderSpec becomes a Film. Behind it: decoding, baking, residency, one GL thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/budget_cache.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/gl/context.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"
#include "renderer/image/image.hpp"
#include "renderer/residency/prepared_scene.hpp"
#include "renderer/scene/render_spec.hpp"
#include "renderer/scene/scene.hpp"
#include "renderer/scene/sequence.hpp"
#include "renderer/context_stats.hpp"

namespace furnace {

class Decoder;
class WorkerPool;

struct RendererConfig {
  gl::ContextConfig gl;  // its device may be several: "0,1"
  int contexts = 0;      // over the devices in turn; 0: one on each
  ContextLife context_life;
  std::string build_id;                               // of the program, for the fingerprint
  std::string shader_dir;                             // empty: the shaders in the binary
  std::int64_t scene_cache_bytes = 256ll << 20;       // parsed scenes
  std::int64_t bake_cache_bytes = 512ll << 20;        // baked environments, CPU
  std::int64_t background_cache_bytes = 512ll << 20;  // backgrounds of their own, CPU
  std::filesystem::path data_folder;                  // of the disk cache; empty: none
  std::int64_t disk_cache_bytes = 4096ll << 20;       // baked environments on disk
  std::int64_t gpu_cache_bytes = 1024ll << 20;  // meshes, textures, environments on the GPU, per context
  int max_tile_px = 1024;                       // larger pictures are drawn in tiles of this side
  ImportLimits import;
  DecodeLimits texture;  // the side is also held within the GPU's
  DecodeLimits environment{8192, 8192ll * 4096};
};

// Wall times of one render's stages, milliseconds; a stage that was served from a cache has `hit` set.
struct StageTimes {
  double queue_ms = 0, decode_ms = 0, bake_ms = 0, upload_ms = 0, draw_ms = 0, readback_ms = 0, encode_ms = 0;
  bool decode_hit = false, bake_hit = false, upload_hit = false;
  bool bake_from_disk = false;  // with bake_hit: it was not in memory
};

// Hears what a picture waits for ("bake", "draw": constants) and how much of it is done, 0 where that is not known; on the
// thread that asked for it. May throw to end it.
using TellStage = std::function<void(std::string_view stage, double share)>;

// A finished picture before encoding.
struct Film {
  // PNG, JPEG, WebP: kUint8 (or kUint16) kSrgb, RGB (opaque background) or RGBA straight alpha. EXR: kFloat16/32 kLinear, RGB or RGBA premultiplied.
  Image image;
  std::vector<ImageLayer> layers;     // beside it
  std::vector<TextField> attributes;  // that a file of these layers carries
  std::vector<Note> notes;            // what was not drawn as asked
  StageTimes times;
  double exposure_ev = 0;  // stops by which radiance was multiplied
};

struct SceneOutline {
  FrameOutline frame;
  double longest_clip_s = 0;  // of those that play
};

struct EnvironmentAnswer {
  EnvironmentSummary summary;
  bool was_cached = false;
};

// What makes pixels besides the request: part of every ETag.
struct Fingerprint {
  std::string build;         // RendererConfig::build_id
  std::string shaders;       // hash of the shader library
  std::string gl;            // GL_RENDERER / GL_VERSION
  std::string text() const;  // one line, for the Furnace-Fingerprint header
};

struct RendererStats {
  ContextPoolStats contexts;
  CacheStats baked;              // environments in memory
  bool probes_are_alike = true;  // every probe so far, on every context, had the pixels of the first
};

// Threads: any. Owns: the GL threads and every cache behind them.
class Renderer {
 public:
  // Builds the GL contexts; fails with kGpuUnavailable. `pool` and `decoder` must outlive it.
  Renderer(const RendererConfig& config, WorkerPool& pool, Decoder& decoder);
  ~Renderer();

  // Errors: those of import, decode, bake, framing; kDeadlineExceeded; kGpuUnavailable.
  Film render(const RenderSpec& spec, const Deadline& deadline, const TellStage& tell = {});

  // What a camera must see of a picture's scene, and how long its clips are. Errors: those of import; of outline_of.
  SceneOutline outline(const RenderSpec& spec, const Deadline& deadline);

  // What a bake of the environment found; bakes it when no cache has it, as a render would. Errors: those of decode and bake.
  EnvironmentAnswer environment(const EnvironmentSpec& spec, const Deadline& deadline);

  // Draws a tiny built-in probe on every context and checks its pixels; false when some are wrong.
  bool probe(const Deadline& deadline);

  // For how long a GL thread has worked beyond the time of what it works on: it looks at the time between sub-frames, so more
  // than some seconds mean that a driver does not come back.
  std::chrono::milliseconds overdue() const;

  const Fingerprint& fingerprint() const;
  const gl::Limits& limits() const;
  RendererStats stats() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furnace
