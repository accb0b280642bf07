// A whole bake of one HDRI for its own sake: maps to look at, to score and to download.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "renderer/base/blob.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/base/worker_pool.hpp"
#include "renderer/ibl/baked_environment.hpp"
#include "renderer/ibl/suns.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/scene/decoder.hpp"
#include "renderer/scene/render_spec.hpp"

namespace furnace {

enum class IrradianceMethod { kSpectral, kRiemann };

struct EnvironmentBakeSettings {
  IrradianceMethod irradiance = IrradianceMethod::kSpectral;
  SunMode sun = SunMode::kKeep;  // kAuto is kKeep
  EnvironmentLayout layout = EnvironmentLayout::kAuto;
  DecodeLimits limits{8192, 8192ll * 4096};
  BakeProgress progress = {};  // 0 .. 1, of the spectral bake
};

struct EnvironmentMap {
  std::string name;                 // "irradiance", "ggx_00", "charlie_03", ...
  std::string kernel;               // "cosine", "none", "ggx", "charlie"
  double perceptual_roughness = 0;  // of "ggx" and "charlie"
  const Image* equirect = nullptr;  // RGB kFloat32; lives with the bake
};

// Threads: immutable. Owns: its maps.
struct EnvironmentBake {
  Extent size;
  EnvironmentLayout layout = EnvironmentLayout::kEquirect;  // of the file
  RepairReport repairs;
  std::vector<Sun> suns;        // found in the map
  bool suns_extracted = false;  // the maps are those of the residual
  std::shared_ptr<const BakedEnvironment> maps;
  Image riemann_irradiance;  // of IrradianceMethod::kRiemann, else empty
  double decode_ms = 0, bake_ms = 0;

  // Irradiance, then the GGX levels from the environment itself on, then the Charlie levels.
  std::vector<EnvironmentMap> list() const;
};

// Decodes and bakes. Errors: those of Decoder::environment; kDeadlineExceeded. Threads: any.
EnvironmentBake bake_whole_environment(const Blob& encoded, const EnvironmentBakeSettings& settings,
                                       WorkerPool& pool, Decoder& decoder, const Deadline& deadline);

}  // namespace furnace
