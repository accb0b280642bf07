// EXT_meshopt_compression, KHR_meshopt_compression: a compressed buffer view -> its bytes. Inputs and outputs are
// values, no document is needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace furnace {

enum class MeshoptMode : std::uint8_t { kAttributes, kTriangles, kIndices };
enum class MeshoptFilter : std::uint8_t { kNone, kOctahedral, kQuaternion, kExponential, kColor };

struct MeshoptLayout {
  MeshoptMode mode = MeshoptMode::kAttributes;
  MeshoptFilter filter = MeshoptFilter::kNone;
  std::uint64_t count = 0;   // elements; of triangles: indices
  std::uint64_t stride = 0;  // bytes of an element
};

// What is wrong with a layout, by the extensions' rules; null for a sound one.
const char* meshopt_fault(const MeshoptLayout& layout);

// `count` * `stride` bytes; the layout must be sound. Indices may be out of any range. Errors: kUnprocessable for
// what is damaged or claims more than so many bytes can hold. Threads: any.
std::vector<std::byte> decode_meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout);

}  // namespace furnace
