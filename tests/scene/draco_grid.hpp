// A mesh that Draco's own encoder wrote.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "renderer/scene/draco_decode.hpp"
#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {

inline constexpr int kSide = 9;  // vertices of the grid
inline constexpr std::uint32_t kVertices = kSide * kSide, kTriangles = 2 * (kSide - 1) * (kSide - 1);

inline glm::vec3 grid_position(int i) {
  const int x = i % kSide, y = i / kSide;
  return {float(x), float(y), std::sin(float(x) * 0.7f) + 0.25f * float(y)};
}

inline std::array<std::uint8_t, 4> grid_joints(int i) {
  return {std::uint8_t(i), std::uint8_t(200 - i), 0, 255};
}

template <class T, std::size_t N>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data,
                  std::array<T, N> (*value)(int)) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, N, data, false, sizeof(T) * N, 0);
  const int id = mesh.AddAttribute(attribute, true, kVertices);
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    const std::array<T, N> one = value(int(i));
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), one.data());
  }
  return id;
}

// A wavy grid with positions (id 0) and joints (id 1).
inline std::string encoded_grid(bool edgebreaker) {
  draco::Mesh mesh;
  mesh.set_num_points(kVertices);
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 0; x + 1 < kSide; ++x) {
      const auto at = [&](int dx, int dy) {
        return draco::PointIndex(std::uint32_t(x + dx + (y + dy) * kSide));
      };
      mesh.AddFace({at(0, 0), at(1, 0), at(0, 1)});
      mesh.AddFace({at(1, 0), at(1, 1), at(0, 1)});
    }
  }
  const int position = add_attribute<float, 3>(
      mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, +[](int i) {
        const glm::vec3 p = grid_position(i);
        return std::array<float, 3>{p.x, p.y, p.z};
      });
  add_attribute<std::uint8_t, 4>(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, grid_joints);
  draco::ExpertEncoder encoder(mesh);
  encoder.SetAttributeQuantization(position, 14);
  encoder.SetEncodingMethod(edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  return {buffer.data(), buffer.size()};
}

inline std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

inline DracoRequest grid_request() {
  DracoRequest request;
  request.attributes = {{0, DracoComponent::kFloat, 3}, {1, DracoComponent::kUnsignedByte, 4}};
  request.vertices = kVertices;
  request.most_triangles = kTriangles;
  return request;
}

// The grid as a document whose accessors have no bytes of their own.
inline GltfBuilder grid_document(bool edgebreaker = true) {
  GltfBuilder builder;
  const std::string file = encoded_grid(edgebreaker);
  const int view = builder.add_view(std::vector<std::uint8_t>(file.begin(), file.end()));
  const int position =
      builder.add("accessors", {{"type", "VEC3"}, {"componentType", 5126}, {"count", kVertices}});
  const int indices =
      builder.add("accessors", {{"type", "SCALAR"}, {"componentType", 5123}, {"count", 3 * kTriangles}});
  builder.show(
      {{"attributes", {{"POSITION", position}}},
       {"indices", indices},
       {"extensions",
        {{"KHR_draco_mesh_compression", {{"bufferView", view}, {"attributes", {{"POSITION", 0}}}}}}}});
  builder.json["extensionsRequired"] = builder.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  return builder;
}

}  // namespace furnace::testing
