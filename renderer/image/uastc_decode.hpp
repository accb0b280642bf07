// Basis Universal's UASTC LDR 4x4: blocks of 16 bytes, a subset of ASTC.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace furnace {

inline constexpr std::size_t kUastcBlockBytes = 16;

using UastcTexels = std::array<std::array<std::uint8_t, 4>, 16>;  // RGBA, rows one after another

// False for a block of the reserved mode or with a pattern that there is not. `block` has 16 bytes. Threads: any.
bool decode_uastc_block(std::span<const std::byte> block, UastcTexels& out);

// For each texel of a pattern its subset, two bits each from the first texel on; what the format's tables say.
// `mode` is one with subsets. Threads: any.
std::uint32_t uastc_pattern(unsigned mode, std::size_t index);
std::size_t uastc_pattern_count(unsigned mode);

}  // namespace furnace
