#include "renderer/scene/draco_decode.hpp"

#include <algorithm>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <draco/compression/decode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

// Regular connectivity costs next to nothing: beyond so many triangles a file must have bytes to show for them.
constexpr std::uint64_t kFreeTriangles = 1 << 20, kMostTrianglesPerByte = 1024;
// Beside the decoded values Draco keeps portable ones and maps.
constexpr std::uint64_t kWorkingCopies = 3;
constexpr std::uint64_t kTriangleBytes = 3 * sizeof(std::uint32_t);

[[noreturn]] void fail_damaged(const std::string& what) {
  fail(ErrorCode::kUnprocessable, "the Draco data are damaged: " + what);
}

// What the decoder is about to make room for, looked at before it does. Both methods begin with two counts.
class Bounds {
 public:
  Bounds(const DracoRequest& request, std::size_t file_bytes) : request_(request), file_bytes_(file_bytes) {}

  bool connectivity(draco::DecoderBuffer ahead, bool faces_first) {
    std::uint32_t first = 0, second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
    const std::uint64_t faces = faces_first ? first : second, vertices = faces_first ? second : first;
    if (faces > request_.most_triangles) {
      return refuse(ErrorCode::kUnprocessable, "they have " + std::to_string(faces) +
                                                   " triangles; the accessor of indices has room for " +
                                                   std::to_string(request_.most_triangles));
    }
    if (faces > kFreeTriangles && faces / kMostTrianglesPerByte > file_bytes_) {
      return refuse(ErrorCode::kTooLarge, "the Draco data claim " + std::to_string(faces) + " triangles in " +
                                              std::to_string(file_bytes_) + " bytes");
    }
    // Points are vertices with all their attributes: never fewer than vertices.
    return vertices <= request_.vertices || refuse_vertices(vertices);
  }

  bool attributes(const draco::PointCloud& mesh) {
    if (mesh.num_points() != request_.vertices) return refuse_vertices(mesh.num_points());
    std::uint64_t bytes = 0;
    for (int i = 0; i < mesh.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *mesh.attribute(i);
      bytes += kWorkingCopies * mesh.num_points() * attribute.num_components() *
               std::uint64_t(std::max(draco::DataTypeLength(attribute.data_type()), 4));
    }
    if (bytes <= request_.most_bytes) return true;
    return refuse(ErrorCode::kTooLarge, "the Draco mesh takes more than " +
                                            std::to_string(request_.most_bytes) + " bytes to decode");
  }

  // The reason why one of the above said no.
  void rethrow() const {
    if (refusal_) throw Error(*refusal_);
  }

 private:
  bool refuse(ErrorCode code, std::string message) {
    refusal_ = Error{code, std::move(message), {}, {}, {}, {}};
    return false;
  }
  bool refuse_vertices(std::uint64_t vertices) {
    return refuse(ErrorCode::kUnprocessable, "the Draco mesh has " + std::to_string(vertices) +
                                                 " vertices where the accessors have " +
                                                 std::to_string(request_.vertices));
  }

  const DracoRequest& request_;
  const std::size_t file_bytes_;
  std::optional<Error> refusal_;
};

template <class Method>
class BoundedDecoder : public Method {
 public:
  BoundedDecoder(Bounds& bounds, bool faces_first) : bounds_(bounds), faces_first_(faces_first) {}

 protected:
  bool DecodeConnectivity() override {
    return bounds_.connectivity(*this->buffer(), faces_first_) && Method::DecodeConnectivity();
  }
  bool DecodeAllAttributes() override {
    return bounds_.attributes(*this->point_cloud()) && Method::DecodeAllAttributes();
  }

 private:
  Bounds& bounds_;
  const bool faces_first_;
};

std::unique_ptr<draco::MeshDecoder> make_decoder(draco::DecoderBuffer ahead, Bounds& bounds) {
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok()) fail_damaged("their header");
  // The extension names this version; older ones lay out their counts in other ways.
  if (header.version_major != 2 || header.version_minor != 2) {
    fail(ErrorCode::kUnprocessable, "the Draco data are of version " + std::to_string(header.version_major) +
                                        "." + std::to_string(header.version_minor) + "; only 2.2 is read");
  }
  if (header.encoder_type != draco::TRIANGULAR_MESH) fail_damaged("they hold no triangles");
  switch (header.encoder_method) {
    case draco::MESH_SEQUENTIAL_ENCODING:
      return std::make_unique<BoundedDecoder<draco::MeshSequentialDecoder>>(bounds, true);
    case draco::MESH_EDGEBREAKER_ENCODING:
      return std::make_unique<BoundedDecoder<draco::MeshEdgebreakerDecoder>>(bounds, false);
    default:
      fail_damaged("their method is not known");
  }
}

std::vector<std::uint32_t> read_indices(const draco::Mesh& mesh) {
  std::vector<std::uint32_t> indices;
  indices.reserve(std::size_t(mesh.num_faces()) * 3);
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
    for (const draco::PointIndex& corner : mesh.face(face)) {
      if (corner.value() >= mesh.num_points()) fail_damaged("an index is out of range");
      indices.push_back(corner.value());
    }
  }
  return indices;
}

std::uint64_t vertex_bytes(const DracoRequest& request) {
  std::uint64_t bytes = 0;
  for (const DracoAttribute& attribute : request.attributes) bytes += element_bytes(attribute);
  return bytes;
}

template <class T>
std::vector<std::byte> converted(const draco::PointAttribute& attribute, std::uint32_t points,
                                 const DracoAttribute& wanted) {
  const std::size_t element = element_bytes(wanted);
  std::vector<std::byte> values(points * element);
  for (std::uint32_t i = 0; i < points; ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute.size()) fail_damaged("a vertex has no value of an attribute");
    if (!attribute.ConvertValue<T>(value, std::int8_t(wanted.components),
                                   reinterpret_cast<T*>(values.data() + i * element))) {
      fail_damaged("an attribute does not fit its accessor's component type");
    }
  }
  return values;
}

std::vector<std::byte> read_attribute(const draco::Mesh& mesh, const DracoAttribute& wanted) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(wanted.id);
  if (attribute == nullptr) fail_damaged("they have no attribute " + std::to_string(wanted.id));
  if (attribute->num_components() != wanted.components) {
    fail_damaged("attribute " + std::to_string(wanted.id) + " has " +
                 std::to_string(attribute->num_components()) + " components where the accessor has " +
                 std::to_string(wanted.components));
  }
  const std::uint32_t points = mesh.num_points();
  switch (wanted.component) {
    case DracoComponent::kByte:
      return converted<std::int8_t>(*attribute, points, wanted);
    case DracoComponent::kUnsignedByte:
      return converted<std::uint8_t>(*attribute, points, wanted);
    case DracoComponent::kShort:
      return converted<std::int16_t>(*attribute, points, wanted);
    case DracoComponent::kUnsignedShort:
      return converted<std::uint16_t>(*attribute, points, wanted);
    case DracoComponent::kUnsignedInt:
      return converted<std::uint32_t>(*attribute, points, wanted);
    case DracoComponent::kFloat:
      break;
  }
  return converted<float>(*attribute, points, wanted);
}

DracoMesh decode(std::span<const std::byte> bytes, const DracoRequest& request) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Bounds bounds(request, bytes.size());
  const std::unique_ptr<draco::MeshDecoder> decoder = make_decoder(buffer, bounds);
  draco::Mesh mesh;
  const draco::DecoderOptions options;
  const draco::Status status = decoder->Decode(options, &buffer, &mesh);
  bounds.rethrow();
  if (!status.ok())
    fail_damaged(status.error_msg_string().empty() ? "their mesh" : status.error_msg_string());

  DracoMesh result;
  result.indices = read_indices(mesh);
  for (const DracoAttribute& wanted : request.attributes)
    result.attributes.push_back(read_attribute(mesh, wanted));
  return result;
}

}  // namespace

std::size_t element_bytes(const DracoAttribute& attribute) {
  const auto components = std::size_t(attribute.components);
  switch (attribute.component) {
    case DracoComponent::kByte:
    case DracoComponent::kUnsignedByte:
      return components;
    case DracoComponent::kShort:
    case DracoComponent::kUnsignedShort:
      return components * 2;
    case DracoComponent::kUnsignedInt:
    case DracoComponent::kFloat:
      break;
  }
  return components * 4;
}

void check_draco_request(const DracoRequest& request) {
  if (request.attributes.size() > kMostDracoAttributes) {
    fail(ErrorCode::kTooLarge, "has " + std::to_string(request.attributes.size()) + " attributes; " +
                                   std::to_string(kMostDracoAttributes) + " are read at most");
  }
  const std::uint64_t most = request.most_bytes;
  const bool countable = request.most_triangles <= most / kTriangleBytes &&
                         request.vertices <= most / std::max<std::uint64_t>(vertex_bytes(request), 1);
  if (countable && draco_result_bytes(request) <= most) return;
  fail(ErrorCode::kTooLarge, "the Draco mesh takes more than " + std::to_string(most) + " bytes");
}

std::uint64_t draco_result_bytes(const DracoRequest& request) {
  return request.most_triangles * kTriangleBytes + request.vertices * vertex_bytes(request);
}

DracoMesh decode_draco(std::span<const std::byte> bytes, const DracoRequest& request) {
  check_draco_request(request);
  try {
    return decode(bytes, request);
  } catch (const std::bad_alloc&) {
    fail(ErrorCode::kTooLarge, "the Draco mesh takes more memory than there is");
  } catch (const std::length_error&) {
    fail_damaged("a length in them");
  }
}

}  // namespace furnace
