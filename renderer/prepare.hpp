// Decoded pixels in the shapes that residency uploads.
#pragma once

#include <string>
#include <vector>

#include "renderer/residency/prepared_scene.hpp"
#include "renderer/ibl/bake_work.hpp"
#include "renderer/scene/decoder.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/base/worker_pool.hpp"

namespace furnace {

struct PreparedPixels {
  std::vector<Image> levels;  // as DecodedTexture's; RGBA kUint8 or kUint16
  float lowest_green = 0;     // [0, 1]
  std::vector<Note> notes;  // where it is not shown as stored: white stands in for a format that is not read
};

// Errors: kUnprocessable for damaged bytes and kTooLarge over the limits, with `pointer` (into the model); kDeadlineExceeded.
PreparedPixels prepare_texture(Decoder& decoder, const Blob& encoded, ColorSpace color_space,
                               const std::string& pointer, const DecodeLimits& limits,
                               const Deadline& deadline);

// `radiance`: RGB kFloat32 equirect.
PreparedSky prepare_sky(const Image& radiance, const ContentHash& key, WorkerPool& pool);

// Bakes `radiance` (RGB kFloat32 equirect), or what its suns leave, and converts it to half floats with its own power-of-two
// scale.
PreparedEnvironment prepare_environment(Image radiance, bool extracts_suns, const ContentHash& key,
                                        WorkerPool& pool, const Deadline& deadline,
                                        const BakeProgress& progress = {});

}  // namespace furnace
