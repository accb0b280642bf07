// A reply's body that is read from a file while it is sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "renderer/base/descriptor.hpp"

namespace furnace {

// Threads: one at a time. Owns: the open file.
struct FileBody {
  Descriptor file;                        // regular, from its beginning
  std::int64_t bytes = 0;                 // more than 0
  std::shared_ptr<const void> held = {};  // until all is sent

  // Up to `size` bytes at `offset`, some at least; "" when they cannot be read.
  std::string read(std::size_t offset, std::size_t size) const;
};

}  // namespace furnace
