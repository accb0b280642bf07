// EXT_meshopt_compression and KHR_meshopt_compression: what the library's encoders wrote comes back, version 1 by an
// encoder of our own, filters against their closed forms, damage and lies are refused.
#include "renderer/scene/meshopt_decode.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <string>
#include <string_view>

#include <meshoptimizer.h>

#include "tests/scene/gltf_builder.hpp"
#include "tests/scene/meshopt_files.hpp"
#include "tests/support/hex.hpp"

namespace furnace::testing {
namespace {

std::span<const std::byte> span_of(const Bytes& bytes) {
  return std::as_bytes(std::span(bytes));
}

Bytes decoded(const Bytes& bytes, const MeshoptLayout& layout) {
  const std::vector<std::byte> result = decode_meshopt(span_of(bytes), layout);
  const auto* data = reinterpret_cast<const std::uint8_t*>(result.data());
  return {data, data + result.size()};
}

TEST(Meshopt, ReadsVersion0) {
  for (const std::size_t stride : {4, 8, 12, 16, 64, 100, 256}) {
    for (const std::size_t count : {1, 15, 16, 17, 255, 256, 257, 1000}) {
      const Bytes elements = sample_elements(count, stride);
      const Bytes file = encoded_by_library(elements, stride);
      EXPECT_EQ(decoded(file, {MeshoptMode::kAttributes, MeshoptFilter::kNone, count, stride}), elements)
          << stride << " " << count;
    }
  }
}

TEST(Meshopt, ReadsVersion1) {
  for (const std::size_t stride : {4, 12, 16, 256}) {
    for (const std::size_t count : {1, 16, 33, 256, 700}) {
      for (unsigned spread = 0; spread < 6; ++spread) {
        std::vector<std::uint8_t> modes;
        for (std::size_t c = 0; c < stride / 4; ++c)
          modes.push_back(std::array<std::uint8_t, 5>{0, 1, 2, 0x52, 0xf2}[(c + spread) % 5]);
        const Bytes elements = sample_elements(count, stride);
        const Bytes file = Version1(stride, modes, spread).encode(elements);
        ASSERT_EQ(decoded(file, {MeshoptMode::kAttributes, MeshoptFilter::kNone, count, stride}), elements)
            << stride << " " << count << " " << spread;
      }
    }
  }
}

// As meshoptimizer 1.3 wrote it at its highest level: bits turned by 4, words, bytes, words.
TEST(Meshopt, ReadsVersion1OfTheReferenceEncoder) {
  constexpr std::size_t kCount = 20, kStride = 16;
  const Bytes file = test::bytes_of_hex(
      "a1687755bf040300030b020f1317131f262c4f0f1e380f00d8d838040058585858585858585858585858585858585858"
      "052aaaaaaaaa00000000b31b83eb53bb238bf35bc32b93fb63cb339b030200234679abdeffff101112140f001517181a"
      "052aaaaaaaaa0000000204444444444444440f00040404040206666666666666660f0006060606020888888888888888"
      "0f0008080808008a9e4d39da11fd162ac1ad667a715db63521f20046d39f127af86a22afc33656e38f028ae85b310002"
      "060c1014181e22282a30343a3e40484a5054000000000000803f0000e8fd000000000000000042010001");
  Bytes elements(kCount * kStride);
  for (std::uint32_t k = 0; k < kCount; ++k) {
    const float number = 1 - float(k) / 16;
    const std::array words{std::uint16_t(k * 300), std::uint16_t(65000 - k * k * 90)};
    const std::uint32_t square = 0x12345 * k * k;
    std::uint8_t* element = &elements[k * kStride];
    std::memcpy(element, &number, 4);
    std::memcpy(element + 4, words.data(), 4);
    for (std::uint32_t byte = 0; byte < 4; ++byte) element[8 + byte] = std::uint8_t(k * (byte + 1));
    std::memcpy(element + 12, &square, 4);
  }
  ASSERT_EQ(file[file.size() - 4], 0x42);
  EXPECT_EQ(decoded(file, {MeshoptMode::kAttributes, MeshoptFilter::kNone, kCount, kStride}), elements);
}

// The example of the specification: 4-bit deltas with two sentinels, in the first byte of 16 elements.
TEST(Meshopt, ReadsTheSpecificationsExample) {
  Bytes file{0xa0, 0x02, 0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5};
  file.insert(file.end(), 3, 0);   // the other three bytes of an element: all deltas are 0
  file.insert(file.end(), 32, 0);  // padding and a baseline of zeros
  const Bytes out = decoded(file, {MeshoptMode::kAttributes, MeshoptFilter::kNone, 16, 4});
  const std::array<int, 16> deltas{-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0};
  int value = 0;
  for (std::size_t i = 0; i < 16; ++i) {
    value += deltas[i];
    EXPECT_EQ(out[i * 4], std::uint8_t(value)) << i;
    EXPECT_EQ(out[i * 4 + 1], 0);
  }
}

std::vector<std::uint32_t> fan(std::uint32_t triangles) {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < triangles; ++i) indices.insert(indices.end(), {i, i + 1, i + 2 + i % 3});
  return indices;
}

TEST(Meshopt, ReadsTrianglesAndIndices) {
  const std::vector<std::uint32_t> indices = fan(300);
  for (const std::size_t stride : {2, 4}) {
    Bytes expected;
    for (const std::uint32_t index : indices) {
      for (std::size_t k = 0; k < stride; ++k) expected.push_back(std::uint8_t(index >> (8 * k)));
    }
    meshopt_encodeIndexVersion(1);
    Bytes triangles(meshopt_encodeIndexBufferBound(indices.size(), 400));
    triangles.resize(
        meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), indices.size()));
    const Bytes back =
        decoded(triangles, {MeshoptMode::kTriangles, MeshoptFilter::kNone, indices.size(), stride});
    ASSERT_EQ(back.size(), expected.size());
    Bytes sequence(meshopt_encodeIndexSequenceBound(indices.size(), 400));
    sequence.resize(
        meshopt_encodeIndexSequence(sequence.data(), sequence.size(), indices.data(), indices.size()));
    EXPECT_EQ(decoded(sequence, {MeshoptMode::kIndices, MeshoptFilter::kNone, indices.size(), stride}),
              expected);
    // A triangle may come back turned: the same three corners in the same order.
    for (std::size_t i = 0; i < back.size(); i += 3 * stride) {
      Bytes one(back.begin() + std::ptrdiff_t(i), back.begin() + std::ptrdiff_t(i + 3 * stride));
      const Bytes wanted(expected.begin() + std::ptrdiff_t(i),
                         expected.begin() + std::ptrdiff_t(i + 3 * stride));
      int turns = 0;
      while (one != wanted && turns++ < 3)
        std::rotate(one.begin(), one.begin() + std::ptrdiff_t(stride), one.end());
      EXPECT_LT(turns, 3);
    }
  }
}

TEST(Meshopt, UndoesTheOctahedralFilter) {
  const std::vector<float> vectors{0, 0, 1, 0.5f, 0.6f, -0.8f, 0, 1, -0.48f, 0.6f, -0.64f, -1};
  for (const std::size_t stride : {4, 8}) {
    Bytes filtered(3 * stride);
    meshopt_encodeFilterOct(filtered.data(), 3, stride, stride == 4 ? 8 : 12, vectors.data());
    const Bytes out = decoded(encoded_by_library(filtered, stride),
                              {MeshoptMode::kAttributes, MeshoptFilter::kOctahedral, 3, stride});
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float value =
            stride == 4 ? float(std::int8_t(out[i * 4 + c])) / 127
                        : float(std::int16_t(out[i * 8 + c * 2] | out[i * 8 + c * 2 + 1] << 8)) / 32767;
        EXPECT_NEAR(value, vectors[i * 4 + c], stride == 4 ? 0.02 : 0.002);
      }
    }
  }
}

TEST(Meshopt, UndoesTheQuaternionFilter) {
  const std::vector<float> quaternion{0.1f, -0.7f, 0.1f, 0.7f};
  Bytes filtered(8);
  meshopt_encodeFilterQuat(filtered.data(), 1, 8, 12, quaternion.data());
  const Bytes out =
      decoded(encoded_by_library(filtered, 8), {MeshoptMode::kAttributes, MeshoptFilter::kQuaternion, 1, 8});
  double dot = 0;
  for (std::size_t c = 0; c < 4; ++c)
    dot += double(std::int16_t(out[c * 2] | out[c * 2 + 1] << 8)) / 32767 * quaternion[c];
  EXPECT_NEAR(std::abs(dot), 1, 0.001);
}

TEST(Meshopt, UndoesTheExponentialFilter) {
  // 2^-3 * 5 and 2^10 * -3, as the specification packs them.
  Bytes elements{5, 0, 0, 0xfd, 0xfd, 0xff, 0xff, 10};
  const Bytes out =
      decoded(encoded_by_library(elements, 8), {MeshoptMode::kAttributes, MeshoptFilter::kExponential, 1, 8});
  float values[2];
  std::memcpy(values, out.data(), 8);
  EXPECT_EQ(values[0], 0.625f);
  EXPECT_EQ(values[1], -3072.0f);
}

// K bits: Y, Co, Cg of R, G, B as the lifting Y = (R + 2G + B) / 4 gives them, alpha under the bit K - 1.
TEST(Meshopt, UndoesTheColorFilter) {
  // K = 8: grey 200, opaque; K = 8: y + co - cg = 255 (red), y + cg = 0, y - co - cg = 1.
  const Bytes elements{200, 0, 0, 0xff, 64, 127, std::uint8_t(-64), 0x80};
  const Bytes out =
      decoded(encoded_by_library(elements, 4), {MeshoptMode::kAttributes, MeshoptFilter::kColor, 2, 4});
  EXPECT_EQ(out, (Bytes{200, 200, 200, 255, 255, 0, 1, 0}));
  // K = 4 of 16: 15 is all, 8 | 7 = alpha 15 of 15.
  const Bytes wide{15, 0, 0, 0, 0, 0, 15, 0};
  EXPECT_EQ(decoded(encoded_by_library(wide, 8), {MeshoptMode::kAttributes, MeshoptFilter::kColor, 1, 8}),
            Bytes(8, 0xff));
}

TEST(Meshopt, KnowsWhatALayoutMayBe) {
  const auto sound = [](MeshoptMode mode, MeshoptFilter filter, std::uint64_t count, std::uint64_t stride) {
    return meshopt_fault({mode, filter, count, stride}) == nullptr;
  };
  using enum MeshoptMode;
  using enum MeshoptFilter;
  EXPECT_TRUE(sound(kAttributes, kNone, 1, 256));
  EXPECT_FALSE(sound(kAttributes, kNone, 1, 260));
  EXPECT_FALSE(sound(kAttributes, kNone, 1, 0));
  EXPECT_FALSE(sound(kAttributes, kNone, 1, 6));
  EXPECT_FALSE(sound(kAttributes, kOctahedral, 1, 12));
  EXPECT_FALSE(sound(kAttributes, kColor, 1, 16));
  EXPECT_FALSE(sound(kAttributes, kQuaternion, 1, 4));
  EXPECT_TRUE(sound(kAttributes, kExponential, 1, 12));
  EXPECT_FALSE(sound(kTriangles, kNone, 4, 2));
  EXPECT_FALSE(sound(kTriangles, kNone, 3, 1));
  EXPECT_FALSE(sound(kIndices, kColor, 3, 4));
  EXPECT_TRUE(sound(kIndices, kNone, 4, 4));
}

TEST(Meshopt, ClaimsNeedBytes) {
  const Bytes file = encoded_by_library(sample_elements(100, 8), 8);
  const auto error = error_of([&] {
    decoded(file, {MeshoptMode::kAttributes, MeshoptFilter::kNone, std::uint64_t{1} << 50, 8});
  });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kUnprocessable);
}

TEST(Meshopt, DamageEndsInBytesOrAnError) {
  const std::size_t count = 300, stride = 12;
  const Bytes elements = sample_elements(count, stride);
  const MeshoptLayout layout{MeshoptMode::kAttributes, MeshoptFilter::kNone, count, stride};
  for (const Bytes& file :
       {encoded_by_library(elements, stride), Version1(stride, {0, 1, 2}, 1).encode(elements)}) {
    for (std::size_t size = 0; size < file.size(); ++size) {
      const Bytes cut(file.begin(), file.begin() + std::ptrdiff_t(size));
      EXPECT_TRUE(error_of([&] { decoded(cut, layout); })) << size;
    }
    Bytes longer = file;
    longer.push_back(0);
    EXPECT_TRUE(error_of([&] { decoded(longer, layout); }));
    std::mt19937 random(5);
    for (int round = 0; round < 2000; ++round) {
      Bytes broken = file;
      broken[random() % broken.size()] ^= std::uint8_t(1u << random() % 8);
      const auto error = error_of([&] { EXPECT_EQ(decoded(broken, layout).size(), count * stride); });
      EXPECT_TRUE(!error || error->code == ErrorCode::kUnprocessable);
    }
  }
}

class MeshoptDocument : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Names, MeshoptDocument,
                         ::testing::Values("EXT_meshopt_compression", "KHR_meshopt_compression"));

TEST_P(MeshoptDocument, FillsTheViews) {
  const GltfBuilder builder = compressed_triangle(GetParam());
  const Json flag = {{"extensions", {{GetParam(), {{"fallback", true}}}}}};
  Json lost = flag;
  lost["uri"] = "fallback.bin";
  for (const Json& placeholder : {Json::object(), flag, lost}) {
    const ModelBundle bundle = with_placeholder(builder, placeholder);
    const Scene scene = import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
    EXPECT_EQ(world_bounds(scene).max, glm::vec3(2, 2, 0));
    EXPECT_EQ(scene.meshes.at(0)->indices, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(gltf_external_uris(bundle.document, {}), std::vector<std::string>{"data.bin"});
  }
}

TEST_P(MeshoptDocument, RefusesWhatCannotBe) {
  const std::string at = "/bufferViews/0/extensions/" + std::string(GetParam());
  const auto pointer_with = [&](const std::string& key, const Json& value) {
    GltfBuilder builder = compressed_triangle(GetParam());
    builder.json["bufferViews"][0]["extensions"][GetParam()][key] = value;
    const auto error = error_of([&] {
      import_gltf(decode::in_process_decoder(), with_placeholder(builder, Json::object()), {}, {},
                  Deadline());
    });
    return error ? error->pointer : "no error";
  };
  EXPECT_EQ(pointer_with("mode", "VERTICES"), at + "/mode");
  EXPECT_EQ(pointer_with("filter", "GZIP"), at + "/filter");
  EXPECT_EQ(pointer_with("filter", "QUATERNION"), at);
  EXPECT_EQ(pointer_with("byteStride", 10), at);
  EXPECT_EQ(pointer_with("count", 4), at + "/count");
  EXPECT_EQ(pointer_with("byteLength", 1u << 30), at + "/byteLength");
  EXPECT_EQ(pointer_with("byteLength", 3), at);
  EXPECT_EQ(pointer_with("buffer", 2), at + "/buffer");
  EXPECT_EQ(pointer_with("buffer", 1), "/buffers/1");
}

}  // namespace
}  // namespace furnace::testing
