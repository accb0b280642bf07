// The bytes behind a document, and accessors decoded into plain arrays: strides, normalised integers, sparse
// values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/decoder.hpp"
#include "renderer/scene/gltf_document.hpp"

namespace furnace {

// Threads: one. Owns: decoded data: URIs, decompressed views and shares of the bundle's bytes; the document and the
// decoder must outlive it.
class GltfData {
 public:
  // Errors: kUnprocessable for a buffer that is missing, shorter than declared, or has a bad URI, and for damaged
  // meshopt data; kDeadlineExceeded.
  GltfData(const GltfDocument& document, const ModelBundle& bundle, const ImportLimits& limits,
           Decoder& decoder, const Deadline& deadline);

  const GltfAccessor& accessor(int index) const {
    return document_.accessors[static_cast<std::size_t>(index)];
  }
  // A part of the bundle's own bytes, not a copy, unless it comes compressed.
  Blob view_blob(int buffer_view) const;
  // The view as a compressed mesh. Errors: those of Decoder::draco.
  DracoMesh read_draco(int buffer_view, const DracoRequest& request) const;

  // Floats, normalised integers converted; V has as many components as the accessor's type, or more (left as
  // `fill`). `decoded`: all elements, tightly packed, where a compressed mesh brought them.
  template <class V>
  std::vector<V> read_vectors(int accessor_index, V fill = V(0),
                              std::span<const std::byte> decoded = {}) const {
    check_zeros(accessor_index, decoded);
    std::vector<V> result(static_cast<std::size_t>(accessor(accessor_index).count), fill);
    read_floats(accessor_index, decoded, reinterpret_cast<float*>(result.data()), sizeof(V) / sizeof(float));
    return result;
  }
  // All components, one element after the other.
  std::vector<float> read_numbers(int accessor_index) const;
  std::vector<glm::mat4> read_matrices(int accessor_index) const;
  std::vector<glm::uvec4> read_joints(int accessor_index, std::span<const std::byte> decoded = {}) const;
  std::vector<std::uint32_t> read_indices(int accessor_index) const;

 private:
  struct Buffer {
    Blob owner;
    ByteRange range;
    bool present = false;
  };

  Buffer find_buffer(std::size_t index, const ModelBundle& bundle) const;
  void decode_views(const ImportLimits& limits);
  std::span<const std::byte> buffer_bytes(int buffer, std::uint64_t offset, std::uint64_t size) const;
  std::span<const std::byte> view_bytes(int buffer_view) const;
  void check_zeros(int accessor_index, std::span<const std::byte> decoded) const;
  void read_floats(int accessor_index, std::span<const std::byte> decoded, float* target,
                   std::size_t target_components) const;
  template <class Out>
  void read_elements(int accessor_index, std::span<const std::byte> decoded, Out* target,
                     std::size_t target_components) const;
  std::vector<std::uint32_t> read_sparse_indices(int accessor_index) const;

  const GltfDocument& document_;
  Decoder& decoder_;
  const Deadline deadline_;
  std::vector<Buffer> buffers_;
  std::map<int, std::vector<std::byte>> decoded_views_;  // those of meshopt
};

}  // namespace furnace
