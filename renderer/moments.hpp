// A request's scene at the moments of its shutter.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "renderer/compose.hpp"

namespace furnace {

// Threads: immutable once built. Owns: its scenes, which share what does not change from one to the next.
struct ComposedMoments {
  std::vector<std::shared_ptr<const ComposedScene>> scenes;
  std::vector<double> offsets_s;  // of each, from the shutter's middle

  std::size_t byte_size() const;  // each mesh once
};

// What all moments have of their own takes at most so much: meshes that deform, and for each instance, material, light and camera
// what is made of it on its way to the GPU. A scene that takes more is seen at fewer moments. It decides pixels, so it is no
// setting.
inline constexpr std::int64_t kMostMomentBytes = 512ll << 20;

struct Shutter {
  int subframes = 1, moments = 1;  // as moment_offsets_s()
  double open_s = 0;
};

// The imported model, or null without one, as its clips stand.
using ImportAt = std::function<std::shared_ptr<const Scene>(const std::vector<AnimationClip>& clips)>;

// `middle`: compose_scene(spec), whose meshes are shared. Of fewer moments than are wanted where `most_bytes` asks for it.
// Errors: as compose_scene; what `import_at` throws.
ComposedMoments compose_moments(const SceneSpec& spec, const ComposedScene& middle, Shutter shutter,
                                std::int64_t most_bytes, const ImportAt& import_at);

}  // namespace furnace
