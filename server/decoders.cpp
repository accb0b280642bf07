#include "server/decoders.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

namespace furnace {
namespace {

decode::PoolConfig pool_config(const Config& config) {
  decode::PoolConfig out;
  out.command.limits.memory_bytes = config.decoder_memory_bytes;
  out.processes =
      config.decoders > 0 ? config.decoders : std::max(1, int(std::thread::hardware_concurrency()));
  out.needs_whole_sandbox = config.decoder_sandbox == "require";
  out.timeout = std::chrono::milliseconds(config.decoder_timeout_ms);
  out.jobs_per_process = config.decoder_jobs;
  out.bytes_per_process = config.decoder_bytes;
  return out;
}

}  // namespace

Decoders::Decoders(const Config& config) {
  if (config.decoder_sandbox != "off")
    processes_ = std::make_unique<decode::ProcessDecoder>(pool_config(config));
}

}  // namespace furnace
