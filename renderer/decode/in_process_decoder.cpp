#include "renderer/decode/in_process_decoder.hpp"

namespace furnace::decode {
namespace {

// Threads: any. Owns: nothing.
class InProcessDecoder : public Decoder {
 public:
  DecodedTexture texture(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits,
                         const Deadline&) override {
    return decode_texture(file, color_space, limits);
  }
  DecodedEnvironment environment(std::span<const std::byte> file, EnvironmentLayout layout,
                                 const DecodeLimits& limits, const Deadline&) override {
    return decode_environment(file, limits, layout);
  }
  DracoMesh draco(std::span<const std::byte> bytes, const DracoRequest& request, const Deadline&) override {
    return decode_draco(bytes, request);
  }
  std::vector<std::byte> meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout,
                                 const Deadline&) override {
    return decode_meshopt(bytes, layout);
  }
  PlainModel model(std::span<const std::byte> document, std::string_view materials, ModelFormat format,
                   const PlainModelLimits& limits, const Deadline& deadline) override {
    return decode_model(document, materials, format, limits, deadline);
  }
};

}  // namespace

Decoder& in_process_decoder() {
  static InProcessDecoder decoder;
  return decoder;
}

}  // namespace furnace::decode
