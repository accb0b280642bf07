// What a bake makes of one HDRI: every map the shaders read, as plain pixels, without GL.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "renderer/base/deadline.hpp"
#include "renderer/ibl/bake_work.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// Equirect convention of every map, that of three.js: row 0 is +Y; with texel centre (u, v) in [0,1]^2,
//   theta = pi * v,  phi = 2 pi * (u - 0.5),  direction = (sin(theta) cos(phi), cos(theta), sin(theta) sin(phi));
// the centre column looks to +X, u = 0.75 to +Z, u = 0.25 to -Z.

// Raised whenever a bake of the same input and settings changes its result.
inline constexpr int kBakeVersion = 3;

// The perceptual roughness of GGX level i. Level 0 (roughness 0) is the environment itself and is not in `levels`.
// One function for baker, shader tables and cache keys. Strictly increasing, ends at 1.
std::vector<double> ggx_level_roughness();

// The same of the Charlie levels, for sheen. The first is the least that KHR_materials_sheen's renderers take.
std::vector<double> charlie_level_roughness();

// Between two levels maps are mixed linearly in this coordinate: by r^3 the tails of the kernels and the contrast they
// leave are mixed with the least error up to r = 0.4, by something flatter above (fitted to measured errors).
inline double level_coordinate(double perceptual_roughness) {
  const double cube = perceptual_roughness * perceptual_roughness * perceptual_roughness;
  return cube / (1 + 1.8 * cube);
}

// A prefiltered radiance map on an equirect grid just fine enough for its band limit.
struct BakedLevel {
  double perceptual_roughness = 0;
  Image equirect;  // RGB kFloat32: radiance in the HDRI's own unit; kernel integral 1
};

// Threads: immutable after the bake. Owns: its pixels.
struct BakedEnvironment {
  ContentHash source_hash;
  std::shared_ptr<const Image> radiance;  // the HDRI itself, RGB kFloat32, 2:1
  std::vector<BakedLevel> levels;         // ggx_level_roughness() without the first
  std::vector<BakedLevel> charlie;        // charlie_level_roughness(), when asked for
  Image irradiance;                       // RGB kFloat32 equirect: irradiance / pi
  std::array<double, 3> mean{};           // solid-angle weighted mean radiance, RGB
  double peak = 0;                        // largest sample of `radiance`
  double bake_ms = 0;                     // wall time, for reports only: never in a picture

  std::size_t byte_size() const;
};

struct BakeSettings {
  bool charlie = false;        // bake the sheen levels too
  BakeProgress progress = {};  // 0 .. 1, at least once a stage
};

// Spectral bake (the derivation stands in bake.cpp). `radiance`: RGB kFloat32 equirect 2:1, finite, >= 0.
// The result does not depend on the number of threads. Errors: kDeadlineExceeded, a few milliseconds of work after it. Threads: any.
std::shared_ptr<const BakedEnvironment> bake_environment(std::shared_ptr<const Image> radiance,
                                                         const ContentHash& source_hash, WorkerPool& pool,
                                                         const Deadline& deadline,
                                                         const BakeSettings& settings = {});

// Luminous flux on a horizontal plane, if the map's values are luminances in cd/m2: pi times the irradiance map at +Y, as
// luminance of linear Rec. 709 (IEC 61966-2-1:1999).
double horizontal_illuminance_lux(const BakedEnvironment& baked);

// Radiance of an equirect RGB kFloat32 map in a unit direction: bilinear in (u, v), periodic in u; across a pole the
// neighbour is the texel opposite (u + 0.5).
std::array<float, 3> sample_equirect(const Image& equirect, double x, double y, double z);

}  // namespace furnace
