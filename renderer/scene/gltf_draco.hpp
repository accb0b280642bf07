// A primitive's numbers where they come compressed (KHR_draco_mesh_compression).
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/gltf_primitive.hpp"

namespace furnace {

// Threads: a value. Owns: what was decompressed; empty for a primitive that is not compressed.
struct DecodedPrimitive {
  std::vector<std::uint32_t> indices;                        // triangles, whatever the primitive's mode
  std::map<std::string, std::vector<std::byte>> attributes;  // by semantic, as their accessors say

  // Empty: the accessor has it.
  std::span<const std::byte> attribute(const std::string& semantic) const {
    const auto found = attributes.find(semantic);
    return found == attributes.end() ? std::span<const std::byte>() : found->second;
  }
};

// Needs check_primitive. Errors: kUnprocessable and kTooLarge at the extension; kDeadlineExceeded.
DecodedPrimitive decode_primitive(const GltfDocument& document, const GltfData& data,
                                  const GltfPrimitiveRef& ref);

}  // namespace furnace
