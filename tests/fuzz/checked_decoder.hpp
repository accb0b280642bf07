// Decoding in the process, each result held against what a decoder's process may answer.
#pragma once

#include "renderer/base/check.hpp"
#include "renderer/decode/jobs.hpp"
#include "renderer/scene/decoder.hpp"

namespace furnace::fuzz {

// The job's result, which its own judge must take and its block must hold.
template <class Job>
auto checked(const Job& job, std::span<const std::byte> file) {
  auto result = job.run(file);
  FURNACE_CHECK(job.accepts(result), "{}: not what a decoder may answer", Job::kName);
  return result;
}

// Threads: any. Owns: nothing.
class CheckedDecoder : public Decoder {
 public:
  DecodedTexture texture(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits,
                         const Deadline&) override {
    return checked(decode::TextureJob{color_space, limits}, file);
  }
  DecodedEnvironment environment(std::span<const std::byte> file, EnvironmentLayout layout,
                                 const DecodeLimits& limits, const Deadline&) override {
    return checked(decode::EnvironmentJob{limits, layout}, file);
  }
  DracoMesh draco(std::span<const std::byte> bytes, const DracoRequest& request, const Deadline&) override {
    check_draco_request(request);
    return checked(decode::DracoJob{request}, bytes);
  }
  std::vector<std::byte> meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout,
                                 const Deadline&) override {
    return checked(decode::MeshoptJob{layout}, bytes).bytes;
  }
  PlainModel model(std::span<const std::byte> document, std::string_view materials, ModelFormat format,
                   const PlainModelLimits& limits, const Deadline&) override {
    std::string both(reinterpret_cast<const char*>(document.data()), document.size());
    both += materials;
    return checked(decode::ModelJob{format, document.size(), limits}, std::as_bytes(std::span(both)));
  }
};

}  // namespace furnace::fuzz
