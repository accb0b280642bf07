// Which process decodes, as configured.
#pragma once

#include <memory>

#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/decode/process_decoder.hpp"
#include "server/config.hpp"

namespace furnace {

// Threads: any. Owns: the child processes, if there are any.
class Decoders {
 public:
  // Errors: kInternal, when no child starts, or its sandbox is not whole and has to be.
  explicit Decoders(const Config& config);

  Decoder& decoder() {
    return processes_ ? static_cast<Decoder&>(*processes_) : decode::in_process_decoder();
  }
  // Null: files are decoded in this process.
  const decode::ProcessDecoder* processes() const { return processes_.get(); }

 private:
  std::unique_ptr<decode::ProcessDecoder> processes_;
};

}  // namespace furnace
