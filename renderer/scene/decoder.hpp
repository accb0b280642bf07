// The seam between bytes that nobody vouches for and everything else: codecs are behind it, plain values come out.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/scene/draco_decode.hpp"
#include "renderer/scene/meshopt_decode.hpp"
#include "renderer/scene/plain_model.hpp"

namespace furnace {

// Errors: those of the function that each names; where decoding is another process also kUnprocessable, when that fails on
// the file or takes too long over it, and kDeadlineExceeded.
// Threads: any.
class Decoder {
 public:
  virtual ~Decoder() = default;

  // As decode_texture.
  virtual DecodedTexture texture(std::span<const std::byte> file, ColorSpace color_space,
                                 const DecodeLimits& limits, const Deadline& deadline) = 0;
  // As decode_environment.
  virtual DecodedEnvironment environment(std::span<const std::byte> file, EnvironmentLayout layout,
                                         const DecodeLimits& limits, const Deadline& deadline) = 0;
  // As decode_draco.
  virtual DracoMesh draco(std::span<const std::byte> bytes, const DracoRequest& request,
                          const Deadline& deadline) = 0;
  // As decode_meshopt.
  virtual std::vector<std::byte> meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout,
                                         const Deadline& deadline) = 0;
  // As decode_model.
  virtual PlainModel model(std::span<const std::byte> document, std::string_view materials,
                           ModelFormat format, const PlainModelLimits& limits, const Deadline& deadline) = 0;
};

}  // namespace furnace
