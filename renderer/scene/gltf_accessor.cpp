#include "renderer/scene/gltf_accessor.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"

namespace furnace {

namespace {

// glTF 2.0, section 3.6.2.2: signed integers reach -1 at two codes.
template <class T, class Out>
Out convert(T value, bool normalized) {
  if constexpr (std::is_floating_point_v<Out> && std::is_integral_v<T>) {
    if (!normalized) return static_cast<Out>(value);
    return std::max(static_cast<Out>(value) / static_cast<Out>(std::numeric_limits<T>::max()), Out(-1));
  } else {
    return static_cast<Out>(value);
  }
}

struct Layout {
  std::size_t count, stride, components;
  bool normalized;
};

template <class T, class Out>
void decode_run(const std::byte* source, const Layout& layout, Out* target, std::size_t target_stride) {
  for (std::size_t i = 0; i < layout.count; ++i) {
    const std::byte* element = source + i * layout.stride;
    Out* out = target + i * target_stride;
    for (std::size_t c = 0; c < layout.components; ++c) {
      T value;
      std::memcpy(&value, element + c * sizeof(T), sizeof(T));
      out[c] = convert<T, Out>(value, layout.normalized);
    }
  }
}

template <class Out>
void decode(ComponentType type, const std::byte* source, const Layout& layout, Out* target,
            std::size_t target_stride) {
  switch (type) {
    case ComponentType::kByte:
      return decode_run<std::int8_t>(source, layout, target, target_stride);
    case ComponentType::kUnsignedByte:
      return decode_run<std::uint8_t>(source, layout, target, target_stride);
    case ComponentType::kShort:
      return decode_run<std::int16_t>(source, layout, target, target_stride);
    case ComponentType::kUnsignedShort:
      return decode_run<std::uint16_t>(source, layout, target, target_stride);
    case ComponentType::kUnsignedInt:
      return decode_run<std::uint32_t>(source, layout, target, target_stride);
    case ComponentType::kFloat:
      if constexpr (std::is_floating_point_v<Out>) decode_run<float>(source, layout, target, target_stride);
      return;
  }
}

}  // namespace

GltfData::GltfData(const GltfDocument& document, const ModelBundle& bundle, const ImportLimits& limits,
                   Decoder& decoder, const Deadline& deadline)
    : document_(document), decoder_(decoder), deadline_(deadline) {
  std::size_t total = 0;
  for (std::size_t i = 0; i < document.buffers.size(); ++i) {
    buffers_.push_back(find_buffer(i, bundle));
    total += buffers_.back().range.size;
    if (total > static_cast<std::size_t>(limits.max_buffer_bytes)) {
      fail(ErrorCode::kTooLarge,
           "the buffers together exceed the limit of " + std::to_string(limits.max_buffer_bytes) + " bytes",
           "/buffers");
    }
  }
  decode_views(limits);
}

// All of them at once: the same view serves many accessors.
void GltfData::decode_views(const ImportLimits& limits) {
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < document_.buffer_views.size(); ++i) {
    const auto& meshopt = document_.buffer_views[i].meshopt;
    if (!meshopt) continue;
    total += document_.buffer_views[i].byte_length;
    if (total > static_cast<std::uint64_t>(limits.max_buffer_bytes)) {
      fail(ErrorCode::kTooLarge,
           "the decompressed buffer views exceed the limit of " + std::to_string(limits.max_buffer_bytes) +
               " bytes",
           meshopt->pointer);
    }
    const auto bytes = buffer_bytes(meshopt->buffer, meshopt->byte_offset, meshopt->byte_length);
    try {
      decoded_views_.emplace(static_cast<int>(i), decoder_.meshopt(bytes, meshopt->layout, deadline_));
    } catch (Error& error) {
      error.pointer = meshopt->pointer;
      throw;
    }
  }
}

GltfData::Buffer GltfData::find_buffer(std::size_t index, const ModelBundle& bundle) const {
  const GltfBuffer& declared = document_.buffers[index];
  const std::string pointer = "/buffers/" + std::to_string(index);
  Buffer buffer;
  if (declared.is_fallback) return buffer;
  if (!declared.has_uri) {
    // Only the first buffer may be the BIN chunk; any other is a placeholder that an extension would fill.
    if (index != 0 || !document_.binary) return buffer;
    buffer = {bundle.document, *document_.binary, true};
  } else if (is_data_uri(declared.uri)) {
    buffer.owner = Blob(decode_data_uri(declared.uri, pointer + "/uri"));
  } else {
    const auto sibling = bundle.siblings.find(decode_relative_uri(declared.uri, pointer + "/uri"));
    if (sibling == bundle.siblings.end()) {
      fail(ErrorCode::kUnprocessable, "the file " + declared.uri + " is missing", pointer + "/uri");
    }
    buffer.owner = sibling->second;
  }
  if (!buffer.present) buffer = {buffer.owner, {0, buffer.owner.size()}, true};
  if (buffer.range.size < declared.byte_length) {
    fail(ErrorCode::kUnprocessable,
         "is longer than its data of " + std::to_string(buffer.range.size) + " bytes",
         pointer + "/byteLength");
  }
  return buffer;
}

Blob GltfData::view_blob(int buffer_view) const {
  const GltfBufferView& view = document_.buffer_views[static_cast<std::size_t>(buffer_view)];
  const std::span<const std::byte> bytes = view_bytes(buffer_view);
  if (view.meshopt) return Blob(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const Buffer& buffer = buffers_[static_cast<std::size_t>(view.buffer)];
  return Blob::slice(buffer.owner, buffer.range.offset + view.byte_offset, view.byte_length);
}

DracoMesh GltfData::read_draco(int buffer_view, const DracoRequest& request) const {
  return decoder_.draco(view_bytes(buffer_view), request, deadline_);
}

std::span<const std::byte> GltfData::buffer_bytes(int buffer_index, std::uint64_t offset,
                                                  std::uint64_t size) const {
  const Buffer& buffer = buffers_[static_cast<std::size_t>(buffer_index)];
  if (!buffer.present) {
    fail(ErrorCode::kUnprocessable,
         "has no data: there is neither a uri nor a BIN chunk, or it is but a fallback",
         "/buffers/" + std::to_string(buffer_index));
  }
  return buffer.owner.bytes().subspan(buffer.range.offset + offset, size);
}

std::span<const std::byte> GltfData::view_bytes(int buffer_view) const {
  const GltfBufferView& view = document_.buffer_views[static_cast<std::size_t>(buffer_view)];
  if (view.meshopt) return decoded_views_.at(buffer_view);
  return buffer_bytes(view.buffer, view.byte_offset, view.byte_length);
}

// Those of compressed meshes were not among the implied ones that the document's limit counted.
void GltfData::check_zeros(int accessor_index, std::span<const std::byte> decoded) const {
  const GltfAccessor& source = accessor(accessor_index);
  if (source.buffer_view || !decoded.empty() || source.count <= kMaxImpliedElements) return;
  fail(ErrorCode::kTooLarge, "has too many elements without a bufferView",
       "/accessors/" + std::to_string(accessor_index) + "/count");
}

template <class Out>
void GltfData::read_elements(int accessor_index, std::span<const std::byte> decoded, Out* target,
                             std::size_t target_components) const {
  const GltfAccessor& source = accessor(accessor_index);
  const std::size_t element = element_bytes(source.type, source.component);
  const auto components = static_cast<std::size_t>(component_count(source.type));
  FURNACE_CHECK(components <= target_components, "accessor {}: {} components into {}", accessor_index,
                components, target_components);
  Layout layout{static_cast<std::size_t>(source.count), element, components, source.normalized};
  if (!decoded.empty()) {
    FURNACE_CHECK(decoded.size() == layout.count * element, "accessor {}: {} bytes", accessor_index,
                  decoded.size());
    decode(source.component, decoded.data(), layout, target, target_components);
  } else if (source.buffer_view && source.count > 0) {
    const GltfBufferView& view = document_.buffer_views[static_cast<std::size_t>(*source.buffer_view)];
    if (view.byte_stride != 0) layout.stride = view.byte_stride;
    decode(source.component, view_bytes(*source.buffer_view).data() + source.byte_offset, layout, target,
           target_components);
  } else {
    for (std::size_t i = 0; i < layout.count; ++i) {
      std::fill_n(target + i * target_components, components, Out(0));
    }
  }
  if (!source.sparse || source.sparse->count == 0) return;
  const std::vector<std::uint32_t> places = read_sparse_indices(accessor_index);
  const std::byte* values = view_bytes(source.sparse->values_view).data() + source.sparse->values_offset;
  const Layout one{1, element, components, source.normalized};
  for (std::size_t i = 0; i < places.size(); ++i) {
    decode(source.component, values + i * element, one, target + places[i] * target_components,
           target_components);
  }
}

std::vector<std::uint32_t> GltfData::read_sparse_indices(int accessor_index) const {
  const GltfAccessor& source = accessor(accessor_index);
  const GltfSparse& sparse = *source.sparse;
  std::vector<std::uint32_t> places(static_cast<std::size_t>(sparse.count));
  const Layout layout{places.size(), component_bytes(sparse.indices_type), 1, false};
  decode(sparse.indices_type, view_bytes(sparse.indices_view).data() + sparse.indices_offset, layout,
         places.data(), 1);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] >= source.count || (i > 0 && places[i] <= places[i - 1])) {
      fail(ErrorCode::kUnprocessable,
           "index number " + std::to_string(i) + " is out of range or not larger than the one before",
           "/accessors/" + std::to_string(accessor_index) + "/sparse/indices");
    }
  }
  return places;
}

void GltfData::read_floats(int accessor_index, std::span<const std::byte> decoded, float* target,
                           std::size_t target_components) const {
  read_elements(accessor_index, decoded, target, target_components);
}

std::vector<float> GltfData::read_numbers(int accessor_index) const {
  check_zeros(accessor_index, {});
  const auto components = static_cast<std::size_t>(component_count(accessor(accessor_index).type));
  std::vector<float> result(static_cast<std::size_t>(accessor(accessor_index).count) * components);
  read_floats(accessor_index, {}, result.data(), components);
  return result;
}

std::vector<glm::mat4> GltfData::read_matrices(int accessor_index) const {
  check_zeros(accessor_index, {});
  std::vector<glm::mat4> result(static_cast<std::size_t>(accessor(accessor_index).count));
  read_elements(accessor_index, {}, reinterpret_cast<float*>(result.data()), 16);
  return result;
}

std::vector<glm::uvec4> GltfData::read_joints(int accessor_index, std::span<const std::byte> decoded) const {
  check_zeros(accessor_index, decoded);
  std::vector<glm::uvec4> result(static_cast<std::size_t>(accessor(accessor_index).count));
  read_elements(accessor_index, decoded, reinterpret_cast<std::uint32_t*>(result.data()), 4);
  return result;
}

std::vector<std::uint32_t> GltfData::read_indices(int accessor_index) const {
  check_zeros(accessor_index, {});
  std::vector<std::uint32_t> result(static_cast<std::size_t>(accessor(accessor_index).count));
  read_elements(accessor_index, {}, result.data(), 1);
  return result;
}

}  // namespace furnace
