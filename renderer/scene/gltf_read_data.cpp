// Buffers, views and accessors: where numbers lie in the file, checked in 64-bit arithmetic. Offsets and
// counts are at most 2^53 and strides at most 252, so no sum below overflows.
#include <algorithm>
#include <utility>

#include "renderer/scene/gltf_read.hpp"

namespace furnace {

namespace {

constexpr std::array<std::pair<std::string_view, ElementType>, 7> kElementTypes{{
    {"SCALAR", ElementType::kScalar},
    {"VEC2", ElementType::kVec2},
    {"VEC3", ElementType::kVec3},
    {"VEC4", ElementType::kVec4},
    {"MAT2", ElementType::kMat2},
    {"MAT3", ElementType::kMat3},
    {"MAT4", ElementType::kMat4},
}};

ElementType read_element_type(const JsonObject& json) {
  const std::string name = json.required_string("type");
  for (const auto& [known, type] : kElementTypes) {
    if (known == name) return type;
  }
  json.refuse("type", "must be SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
}

ComponentType read_component_type(const JsonObject& json) {
  const std::uint64_t code = json.required_integer("componentType");
  if ((code < 5120 || code > 5126) || code == 5124) {
    json.refuse("componentType", "must be 5120, 5121, 5122, 5123, 5125 or 5126");
  }
  return static_cast<ComponentType>(code);
}

void check_offset(const JsonObject& json, std::uint64_t offset, std::uint64_t view_offset,
                  std::size_t alignment) {
  if (offset % alignment != 0 || (view_offset + offset) % alignment != 0) {
    json.refuse("byteOffset",
                "is not aligned to the component type's " + std::to_string(alignment) + " bytes");
  }
}

void check_fits(const JsonObject& json, std::string_view key, std::uint64_t end, const GltfBufferView& view) {
  if (end > view.byte_length) {
    json.refuse(key, "needs " + std::to_string(end) + " bytes of a bufferView that has " +
                         std::to_string(view.byte_length));
  }
}

GltfSparse read_sparse(const JsonObject& json, const GltfAccessor& accessor,
                       const std::vector<GltfBufferView>& views) {
  const int view_count = static_cast<int>(views.size());
  GltfSparse sparse;
  sparse.count = json.required_integer("count");
  if (sparse.count > accessor.count) json.refuse("count", "exceeds the accessor's count");

  const JsonObject indices = json.required_object("indices");
  sparse.indices_view = indices.required_reference("bufferView", "bufferView", view_count);
  sparse.indices_offset = indices.integer("byteOffset", 0);
  sparse.indices_type = read_component_type(indices);
  if (sparse.indices_type != ComponentType::kUnsignedByte &&
      sparse.indices_type != ComponentType::kUnsignedShort &&
      sparse.indices_type != ComponentType::kUnsignedInt) {
    indices.refuse("componentType", "must be 5121, 5123 or 5125");
  }
  const GltfBufferView& indices_view = views[static_cast<std::size_t>(sparse.indices_view)];
  const std::size_t index_bytes = component_bytes(sparse.indices_type);
  check_offset(indices, sparse.indices_offset, indices_view.byte_offset, index_bytes);
  check_fits(indices, "bufferView", sparse.indices_offset + sparse.count * index_bytes, indices_view);

  const JsonObject values = json.required_object("values");
  sparse.values_view = values.required_reference("bufferView", "bufferView", view_count);
  sparse.values_offset = values.integer("byteOffset", 0);
  const GltfBufferView& values_view = views[static_cast<std::size_t>(sparse.values_view)];
  check_offset(values, sparse.values_offset, values_view.byte_offset, component_bytes(accessor.component));
  const std::size_t element = element_bytes(accessor.type, accessor.component);
  check_fits(values, "bufferView",
             sparse.values_offset + span_bytes(sparse.count, element, accessor.type, accessor.component),
             values_view);
  if (indices_view.byte_stride != 0) indices.refuse("bufferView", "must not have a byteStride");
  if (values_view.byte_stride != 0) values.refuse("bufferView", "must not have a byteStride");
  return sparse;
}

}  // namespace

GltfBuffer read_buffer(const JsonObject& json) {
  GltfBuffer buffer;
  buffer.has_uri = json.has("uri");
  buffer.uri = json.string("uri");
  buffer.is_fallback = is_meshopt_fallback(json);
  buffer.byte_length = json.required_integer("byteLength");
  return buffer;
}

GltfBufferView read_buffer_view(const JsonObject& json, const std::vector<GltfBuffer>& buffers) {
  GltfBufferView view;
  view.buffer = json.required_reference("buffer", "buffer", static_cast<int>(buffers.size()));
  view.byte_offset = json.integer("byteOffset", 0);
  view.byte_length = json.required_integer("byteLength");
  view.byte_stride = json.integer("byteStride", 0);
  const std::uint64_t buffer_bytes = buffers[static_cast<std::size_t>(view.buffer)].byte_length;
  if (view.byte_offset > buffer_bytes || view.byte_length > buffer_bytes - view.byte_offset) {
    json.refuse("byteLength", "reaches beyond the buffer's " + std::to_string(buffer_bytes) + " bytes");
  }
  if (json.has("byteStride") &&
      (view.byte_stride < 4 || view.byte_stride > 252 || view.byte_stride % 4 != 0)) {
    json.refuse("byteStride", "must be a multiple of 4 from 4 to 252");
  }
  view.meshopt = read_meshopt(json, view, buffers);
  return view;
}

GltfAccessor read_accessor(const JsonObject& json, const std::vector<GltfBufferView>& views) {
  GltfAccessor accessor;
  accessor.type = read_element_type(json);
  accessor.component = read_component_type(json);
  accessor.count = json.required_integer("count");
  accessor.normalized = json.boolean("normalized", false);
  accessor.byte_offset = json.integer("byteOffset", 0);
  accessor.buffer_view = json.reference("bufferView", "bufferView", static_cast<int>(views.size()));
  if (accessor.normalized &&
      (accessor.component == ComponentType::kFloat || accessor.component == ComponentType::kUnsignedInt)) {
    json.refuse("normalized", "must be false for component types 5125 and 5126");
  }
  if (accessor.buffer_view) {
    const GltfBufferView& view = views[static_cast<std::size_t>(*accessor.buffer_view)];
    const std::size_t element = element_bytes(accessor.type, accessor.component);
    if (view.byte_stride != 0 && view.byte_stride < element) {
      json.refuse("bufferView", "has a byteStride of " + std::to_string(view.byte_stride) +
                                    ", smaller than an element of " + std::to_string(element) + " bytes");
    }
    const std::uint64_t stride = view.byte_stride != 0 ? view.byte_stride : element;
    check_offset(json, accessor.byte_offset, view.byte_offset, component_bytes(accessor.component));
    check_fits(json, "count",
               accessor.byte_offset + span_bytes(accessor.count, stride, accessor.type, accessor.component),
               view);
  }
  if (const auto sparse = json.object("sparse")) accessor.sparse = read_sparse(*sparse, accessor, views);
  return accessor;
}

}  // namespace furnace
