// Mode 0 of meshopt's bitstream, versions 0 and 1.
#pragma once

#include <cstddef>
#include <span>

namespace furnace {

// Fills `target` with elements of `stride` bytes, a multiple of 4 from 4 to 256. False for what is damaged.
bool decode_meshopt_attributes(std::span<const std::byte> bytes, std::size_t stride,
                               std::span<std::byte> target);

}  // namespace furnace
