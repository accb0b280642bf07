// Decoding in child processes that can do nothing else: what the server does with files of its clients.
#pragma once

#include <utility>

#include "renderer/decode/process_pool.hpp"
#include "renderer/scene/decoder.hpp"

namespace furnace::decode {

// `job` in a child of `pool`; nothing that comes back is used before Job::accepts said so. Errors: those of the job and of
// ProcessPool::run. Threads: any.
template <class Job>
typename Job::Result run_in(ProcessPool& pool, const Job& job, Bytes file, const Deadline& deadline) {
  typename Job::Result result;
  WireWriter arguments;
  fields(arguments, job);
  const auto take = [&](WireReader& answer) {
    fields(answer, result);
    return job.accepts(result);
  };
  pool.run({Job::kKind, Job::kName, arguments.bytes(), file, job.largest_result_bytes(), take}, deadline);
  return result;
}

// Threads: any. Owns: the children.
class ProcessDecoder : public Decoder {
 public:
  explicit ProcessDecoder(const PoolConfig& config) : pool_(config) {}

  DecodedTexture texture(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits,
                         const Deadline& deadline) override {
    return run_in(pool_, TextureJob{color_space, limits}, file, deadline);
  }
  DecodedEnvironment environment(std::span<const std::byte> file, EnvironmentLayout layout,
                                 const DecodeLimits& limits, const Deadline& deadline) override {
    return run_in(pool_, EnvironmentJob{limits, layout}, file, deadline);
  }
  DracoMesh draco(std::span<const std::byte> bytes, const DracoRequest& request,
                  const Deadline& deadline) override {
    check_draco_request(request);
    return run_in(pool_, DracoJob{request}, bytes, deadline);
  }
  std::vector<std::byte> meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout,
                                 const Deadline& deadline) override {
    return std::move(run_in(pool_, MeshoptJob{layout}, bytes, deadline).bytes);
  }
  PlainModel model(std::span<const std::byte> document, std::string_view materials, ModelFormat format,
                   const PlainModelLimits& limits, const Deadline& deadline) override;

  PoolStats stats() const { return pool_.stats(); }
  const std::string& sandbox_problem() const { return pool_.sandbox_problem(); }

 private:
  ProcessPool pool_;
};

}  // namespace furnace::decode
