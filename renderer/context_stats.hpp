// How long a GL context serves, and what became of those there are.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace furnace {

// Drivers leak and fragment; a new context begins with nothing. 0: no such end.
struct ContextLife {
  std::int64_t renders = 0;
  std::chrono::milliseconds age{0};
  std::int64_t process_bytes = 0;  // resident memory of the whole process
};

enum class RenewalReason { kLost, kRenders, kAge, kMemory };
inline constexpr std::size_t kRenewalReasons = 4;
std::string_view name_of(RenewalReason reason);

struct ContextPoolStats {
  std::vector<int> callers;             // of each context: drawing, waiting, or preparing what it will draw
  std::vector<std::int64_t> gpu_bytes;  // of each: meshes, textures and environments on it
  std::array<std::int64_t, kRenewalReasons> renewals{};
};

}  // namespace furnace
