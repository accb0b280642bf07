// Compressed meshes: the same from both processes, and no answer that indexes beyond its vertices.
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/decode/process_decoder.hpp"
#include "renderer/scene/gltf_import.hpp"
#include "tests/scene/draco_grid.hpp"

namespace furnace::decode {
namespace {

namespace fs = std::filesystem;
using testing::bytes_of;
using testing::encoded_grid;
using testing::grid_request;

const fs::path kModels = fs::path(FURNACE_SOURCE_DIR) / ".." / "shared" / "data" / "models";

Decoder& process_decoder() {
  static ProcessDecoder decoder([] {
    PoolConfig config;
    config.command.program = {FURNACE_HOSTILE_WORKER};
    return config;
  }());
  return decoder;
}

template <class Body>
Error error_of(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    return error;
  }
  return Error{ErrorCode::kInternal, "(nothing was thrown)", {}, {}, {}, {}};
}

// What `body` gives, or its error, of both decoders.
template <class Body>
auto expect_same(Body&& body) {
  decltype(body(process_decoder())) ours{}, theirs{};
  const Error here = error_of([&] { ours = body(in_process_decoder()); });
  const Error there = error_of([&] { theirs = body(process_decoder()); });
  EXPECT_EQ(here.code, there.code);
  EXPECT_EQ(here.message, there.message);
  EXPECT_TRUE(ours == theirs);
  return theirs;
}

using Arrays = std::vector<std::vector<std::byte>>;

Arrays draco_arrays(Decoder& decoder, const std::string& file, const DracoRequest& request) {
  DracoMesh mesh = decoder.draco(bytes_of(file), request, Deadline());
  const auto indices = std::as_bytes(std::span(mesh.indices));
  mesh.attributes.emplace_back(indices.begin(), indices.end());
  return std::move(mesh.attributes);
}

TEST(MeshDecoders, AgreeOnDraco) {
  std::mt19937 random(1);
  for (const bool edgebreaker : {false, true}) {
    const std::string file = encoded_grid(edgebreaker);
    const auto same = [&](const std::string& bytes, const DracoRequest& request) {
      return expect_same([&](Decoder& decoder) { return draco_arrays(decoder, bytes, request); });
    };
    EXPECT_EQ(same(file, grid_request()).size(), 3u);
    DracoRequest other = grid_request();
    other.vertices += 1;
    EXPECT_TRUE(same(file, other).empty());
    EXPECT_TRUE(same("", grid_request()).empty());
    for (int round = 0; round < 50; ++round) {
      std::string broken = file;
      broken[random() % broken.size()] ^= char(1u << (random() % 8));
      same(broken, grid_request());
    }
  }
}

TEST(MeshDecoders, RefuseWhatWouldTakeTooMuch) {
  const std::string file = encoded_grid(true);
  const auto code = [&](const DracoRequest& request) {
    ErrorCode codes[2];
    for (int i = 0; i < 2; ++i) {
      Decoder& decoder = i == 0 ? in_process_decoder() : process_decoder();
      codes[i] = error_of([&] { decoder.draco(bytes_of(file), request, Deadline()); }).code;
    }
    EXPECT_EQ(codes[0], codes[1]);
    return codes[1];
  };
  // The same attribute under many names: what comes out is bounded, whatever the mesh has.
  DracoRequest request = grid_request();
  request.attributes.assign(kMostDracoAttributes, {0, DracoComponent::kFloat, 3});
  EXPECT_EQ(code(request), ErrorCode::kInternal);  // nothing wrong
  request.most_bytes = kMostDracoAttributes * 12 * request.vertices;
  EXPECT_EQ(code(request), ErrorCode::kTooLarge);  // no room for the indices
  request = grid_request();
  request.attributes.resize(kMostDracoAttributes + 1, request.attributes[0]);
  EXPECT_EQ(code(request), ErrorCode::kTooLarge);
  for (const std::uint64_t huge : {1ull << 32, 1ull << 62, ~0ull}) {
    request = grid_request();
    request.vertices = huge;
    EXPECT_EQ(code(request), ErrorCode::kTooLarge);
    request = grid_request();
    request.most_triangles = huge;
    EXPECT_EQ(code(request), ErrorCode::kTooLarge);
  }
}

TEST(MeshDecoders, AgreeOnMeshopt) {
  constexpr std::size_t kCount = 300, kStride = 16;
  std::vector<std::uint8_t> elements(kCount * kStride);
  for (std::size_t i = 0; i < elements.size(); ++i) elements[i] = std::uint8_t(i * i / 7);
  meshopt_encodeVertexVersion(0);
  std::string vertices(meshopt_encodeVertexBufferBound(kCount, kStride), '\0');
  vertices.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(vertices.data()),
                                             vertices.size(), elements.data(), kCount, kStride));
  const auto same = [&](const std::string& file, const MeshoptLayout& layout) {
    return expect_same([&](Decoder& decoder) { return decoder.meshopt(bytes_of(file), layout, Deadline()); });
  };
  for (const MeshoptFilter filter : {MeshoptFilter::kNone, MeshoptFilter::kExponential})
    EXPECT_EQ(same(vertices, {MeshoptMode::kAttributes, filter, kCount, kStride}).size(), elements.size());
  const auto plain = same(vertices, {MeshoptMode::kAttributes, MeshoptFilter::kNone, kCount, kStride});
  EXPECT_EQ(std::memcmp(plain.data(), elements.data(), elements.size()), 0);
  EXPECT_TRUE(same(vertices, {MeshoptMode::kTriangles, MeshoptFilter::kNone, kCount, 4}).empty());
  EXPECT_TRUE(same(vertices, {MeshoptMode::kAttributes, MeshoptFilter::kNone, 1 << 20, 256}).empty());
  EXPECT_TRUE(same("", {MeshoptMode::kIndices, MeshoptFilter::kNone, 0, 2}).empty());
  for (std::size_t size = 0; size < vertices.size(); size += 97)
    EXPECT_TRUE(
        same(vertices.substr(0, size), {MeshoptMode::kAttributes, MeshoptFilter::kNone, kCount, kStride})
            .empty());
}

TEST(MeshDecoders, AMeshMustBeWhatWasAskedFor) {
  const DracoJob job{grid_request()};
  const DracoMesh good = in_process_decoder().draco(bytes_of(encoded_grid(true)), job.request, Deadline());
  EXPECT_TRUE(job.accepts(good));
  const std::function<void(DracoMesh&)> lies[] = {
      [&](DracoMesh& mesh) { mesh.indices[7] = std::uint32_t(job.request.vertices); },
      [](DracoMesh& mesh) { mesh.indices.back() = ~0u; },
      [](DracoMesh& mesh) { mesh.indices.pop_back(); },
      [](DracoMesh& mesh) {
        mesh.indices.insert(mesh.indices.end(), {0, 1, 2});
      },
      [](DracoMesh& mesh) { mesh.attributes.pop_back(); },
      [](DracoMesh& mesh) { mesh.attributes.emplace_back(); },
      [](DracoMesh& mesh) { mesh.attributes[0].pop_back(); },
      [](DracoMesh& mesh) { mesh.attributes[1].emplace_back(); },
      [](DracoMesh& mesh) { std::swap(mesh.attributes[0], mesh.attributes[1]); },
  };
  for (const auto& lie : lies) {
    DracoMesh mesh = good;
    lie(mesh);
    EXPECT_FALSE(job.accepts(mesh)) << &lie - lies;
  }
  const MeshoptJob elements{{MeshoptMode::kAttributes, MeshoptFilter::kNone, 3, 8}};
  EXPECT_EQ(elements.largest_result_bytes(), 24);
  EXPECT_TRUE(elements.accepts({std::vector<std::byte>(24)}));
  EXPECT_FALSE(elements.accepts({std::vector<std::byte>(23)}));
  EXPECT_FALSE(elements.accepts({std::vector<std::byte>(25)}));
}

TEST(MeshDecoders, AgreeOnModelsOfOthers) {
  if (!fs::exists(kModels)) GTEST_SKIP() << "the test data are not beside the source";
  for (const char* name : {"KHRMeshoptNoFallback/meshopt-no-fallback.gltf", "BoxMeshopt.glb",
                           "DracoSparseMesh/DracoSparseMesh.gltf"}) {
    const fs::path path = kModels / name;
    ModelBundle bundle;
    bundle.document = Blob(read_file(path, 10 << 20));
    for (const std::string& uri : gltf_external_uris(bundle.document, {}))
      bundle.siblings[uri] = Blob(read_file(path.parent_path() / uri, 10 << 20));
    bundle.seal();
    const auto places = expect_same([&](Decoder& decoder) {
      std::vector<glm::vec3> all;
      for (const SharedMesh& mesh : import_gltf(decoder, bundle, {}, {}, Deadline()).meshes) {
        for (const std::uint32_t index : mesh->indices) all.push_back(mesh->positions.at(index));
      }
      return all;
    });
    EXPECT_GT(places.size(), 0u) << name;
  }
}

}  // namespace
}  // namespace furnace::decode
