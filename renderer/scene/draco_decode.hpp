// KHR_draco_mesh_compression: a compressed mesh -> plain arrays. Inputs and outputs are values, no document is needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace furnace {

// As glTF numbers them (accessor.componentType).
enum class DracoComponent : std::uint16_t {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126,
};

struct DracoAttribute {
  std::uint32_t id = 0;  // unique, in the compressed mesh
  DracoComponent component = DracoComponent::kFloat;
  int components = 3;  // 1..4
};

struct DracoRequest {
  std::vector<DracoAttribute> attributes;
  std::uint64_t vertices = 0;             // what the mesh must have, exactly
  std::uint64_t most_triangles = 0;       // it may have fewer
  std::uint64_t most_bytes = 2ull << 30;  // of all its attributes, wanted or not
};

inline constexpr std::size_t kMostDracoAttributes = 64;
std::size_t element_bytes(const DracoAttribute& attribute);
// Errors: kTooLarge for more attributes than that, and for a result of more than `most_bytes`.
void check_draco_request(const DracoRequest& request);
// What the result takes at most, of a request that was checked.
std::uint64_t draco_result_bytes(const DracoRequest& request);

struct DracoMesh {
  std::vector<std::uint32_t> indices;  // triangles; every index < vertices
  // By request: `vertices` elements, tightly packed, in the component type asked for; quantisation undone.
  std::vector<std::vector<std::byte>> attributes;
};

// Errors: those of check_draco_request; kUnprocessable for what is damaged or is not what was asked for, kTooLarge for the
// limits, which are checked before connectivity and before attributes are decoded. Threads: any.
DracoMesh decode_draco(std::span<const std::byte> bytes, const DracoRequest& request);

}  // namespace furnace
