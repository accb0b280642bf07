// Decoding in the caller's own process and thread: the command line, tests, benchmarks.
#pragma once

#include "renderer/scene/decoder.hpp"

namespace furnace::decode {

// The one there is; it has no state. Threads: any.
Decoder& in_process_decoder();

}  // namespace furnace::decode
