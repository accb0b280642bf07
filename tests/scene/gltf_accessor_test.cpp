#include "renderer/scene/gltf_accessor.hpp"

#include "renderer/scene/gltf_topology.hpp"
#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

// Decodes accessor 0 of a builder's document.
class Accessors {
 public:
  explicit Accessors(const GltfBuilder& builder)
      : bundle_(builder.bundle()),
        document_(read_gltf_document(bundle_.document, {})),
        data_(document_, bundle_, ImportLimits(), decode::in_process_decoder(), Deadline()) {}

  const GltfData& operator*() const { return data_; }

 private:
  ModelBundle bundle_;
  GltfDocument document_;
  GltfData data_;
};

template <class V, class T>
std::vector<V> decoded(const std::string& type, const std::vector<T>& values, bool normalized) {
  GltfBuilder builder;
  builder.add_accessor<T>(type, values, normalized);
  return (*Accessors(builder)).template read_vectors<V>(0);
}

using V2 = std::vector<glm::vec2>;

// glTF 2.0, section 3.6.2.2.
TEST(Accessor, ConvertsEveryComponentType) {
  EXPECT_EQ((decoded<glm::vec2, std::int8_t>("VEC2", {-128, -127, 0, 127}, true)), (V2{{-1, -1}, {0, 1}}));
  EXPECT_EQ((decoded<glm::vec2, std::uint8_t>("VEC2", {0, 255, 51, 1}, true)),
            (V2{{0, 1}, {0.2f, 1 / 255.0f}}));
  EXPECT_EQ((decoded<glm::vec2, std::int16_t>("VEC2", {-32768, -32767, 0, 32767}, true)),
            (V2{{-1, -1}, {0, 1}}));
  EXPECT_EQ((decoded<glm::vec2, std::uint16_t>("VEC2", {0, 65535, 13107, 1}, true)),
            (V2{{0, 1}, {0.2f, 1 / 65535.0f}}));
  EXPECT_EQ((decoded<glm::vec2, std::int8_t>("VEC2", {-128, 127}, false)), (V2{{-128, 127}}));
  EXPECT_EQ((decoded<glm::vec2, std::int16_t>("VEC2", {-32768, 32767}, false)), (V2{{-32768, 32767}}));
  EXPECT_EQ((decoded<glm::vec2, std::uint16_t>("VEC2", {0, 65535}, false)), (V2{{0, 65535}}));
  EXPECT_EQ((decoded<glm::vec2, float>("VEC2", {-0.25f, 3e30f}, false)), (V2{{-0.25f, 3e30f}}));
}

TEST(Accessor, WiderTargetsKeepTheirFill) {
  GltfBuilder builder;
  builder.add_accessor<float>("VEC3", {1, 2, 3, 4, 5, 6});
  const auto values = (*Accessors(builder)).read_vectors<glm::vec4>(0, glm::vec4(1));
  EXPECT_EQ(values, (std::vector<glm::vec4>{{1, 2, 3, 1}, {4, 5, 6, 1}}));
}

TEST(Accessor, FollowsStrideAndOffsets) {
  GltfBuilder builder;
  const int view = builder.add_view<float>({0, 9, 1, 2, 9, 3, 4, 9}, 12);
  builder.json["bufferViews"][0]["byteLength"] = 28;  // the last element ends before the stride does
  builder.add(
      "accessors",
      {{"bufferView", view}, {"byteOffset", 8}, {"type", "VEC2"}, {"componentType", 5126}, {"count", 2}});
  EXPECT_EQ((*Accessors(builder)).read_vectors<glm::vec2>(0), (V2{{1, 2}, {3, 4}}));
}

TEST(Accessor, WithoutAViewIsZeros) {
  GltfBuilder builder;
  builder.add("accessors", {{"type", "VEC2"}, {"componentType", 5126}, {"count", 2}});
  EXPECT_EQ((*Accessors(builder)).read_vectors<glm::vec2>(0, glm::vec2(7)), (V2{{0, 0}, {0, 0}}));
}

GltfBuilder sparse_builder(const std::vector<std::uint16_t>& places, bool with_base) {
  GltfBuilder builder;
  Json accessor = {{"type", "VEC2"}, {"componentType", 5126}, {"count", 3}};
  if (with_base) accessor["bufferView"] = builder.add_view<float>({1, 1, 2, 2, 3, 3});
  std::vector<float> values;
  for (std::size_t i = 0; i < places.size(); ++i) values.insert(values.end(), {10.0f + i, 20.0f + i});
  accessor["sparse"] = {{"count", places.size()},
                        {"indices", {{"bufferView", builder.add_view(places)}, {"componentType", 5123}}},
                        {"values", {{"bufferView", builder.add_view(values)}}}};
  builder.add("accessors", accessor);
  return builder;
}

TEST(Accessor, SparseValuesReplaceThoseOfTheBase) {
  EXPECT_EQ((*Accessors(sparse_builder({0, 2}, true))).read_vectors<glm::vec2>(0),
            (V2{{10, 20}, {2, 2}, {11, 21}}));
  EXPECT_EQ((*Accessors(sparse_builder({1}, false))).read_vectors<glm::vec2>(0),
            (V2{{0, 0}, {10, 20}, {0, 0}}));
}

TEST(Accessor, SparseIndicesMustGrowAndStayInside) {
  for (const std::vector<std::uint16_t>& places : {std::vector<std::uint16_t>{0, 3}, {1, 1}, {2, 0}}) {
    const Accessors decoder(sparse_builder(places, true));
    const auto error = error_of([&] { (*decoder).read_vectors<glm::vec2>(0); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->pointer, "/accessors/0/sparse/indices");
  }
}

TEST(Accessor, IndicesKeepAll32Bits) {
  GltfBuilder builder;
  builder.add_accessor<std::uint32_t>("SCALAR", {0xFFFFFFFEu, 16777217u});
  EXPECT_EQ((*Accessors(builder)).read_indices(0), (std::vector<std::uint32_t>{0xFFFFFFFEu, 16777217u}));
}

// glTF 2.0, section 3.6.2.4, its own example of a padded MAT2 of bytes; the last column's padding may be
// missing.
TEST(Accessor, SmallMatricesHavePaddedColumns) {
  EXPECT_EQ(element_bytes(ElementType::kMat2, ComponentType::kByte), 8u);
  EXPECT_EQ(element_bytes(ElementType::kMat3, ComponentType::kUnsignedByte), 12u);
  EXPECT_EQ(element_bytes(ElementType::kMat3, ComponentType::kShort), 24u);
  EXPECT_EQ(element_bytes(ElementType::kMat4, ComponentType::kFloat), 64u);
  EXPECT_EQ(span_bytes(2, 8, ElementType::kMat2, ComponentType::kByte), 14u);
  EXPECT_EQ(span_bytes(2, 24, ElementType::kMat3, ComponentType::kShort), 46u);
  EXPECT_EQ(span_bytes(2, 12, ElementType::kVec3, ComponentType::kFloat), 24u);
  EXPECT_EQ(span_bytes(0, 12, ElementType::kVec3, ComponentType::kFloat), 0u);
}

// Numbers near 2^53 that would wrap around in 32 bits, or in 64 if multiplied without care.
TEST(Accessor, HugeNumbersDoNotOverflow) {
  for (const std::string key : {"count", "byteOffset"}) {
    for (const std::uint64_t huge :
         {0x40000000ull, 0x100000000ull, 0x15555555555555ull, 0x20000000000000ull}) {
      GltfBuilder builder = triangle_builder();
      builder.json["accessors"][0][key] = huge / 4 * 4;
      EXPECT_EQ(pointer_of_error(builder), "/accessors/0/count") << key << " " << huge;
    }
  }
  GltfBuilder builder = triangle_builder();
  builder.json["bufferViews"][0]["byteOffset"] = 0x1FFFFFFFFFFFFCull;
  EXPECT_EQ(pointer_of_error(builder), "/bufferViews/0/byteLength");
}

TEST(Topology, ExpandsEveryMode) {
  using Indices = std::vector<std::uint32_t>;
  const Indices v{0, 1, 2, 3, 4};
  EXPECT_EQ(expand_topology(0, v), v);
  EXPECT_EQ(expand_topology(1, v), (Indices{0, 1, 2, 3}));
  EXPECT_EQ(expand_topology(2, v), (Indices{0, 1, 1, 2, 2, 3, 3, 4, 4, 0}));
  EXPECT_EQ(expand_topology(3, v), (Indices{0, 1, 1, 2, 2, 3, 3, 4}));
  EXPECT_EQ(expand_topology(4, v), (Indices{0, 1, 2}));
  EXPECT_EQ(expand_topology(5, v), (Indices{0, 1, 2, 1, 3, 2, 2, 3, 4}));
  EXPECT_EQ(expand_topology(6, v), (Indices{1, 2, 0, 2, 3, 0, 3, 4, 0}));
  for (int mode = 0; mode <= 6; ++mode) {
    const std::size_t corners = mode == 0 ? 1 : mode < 4 ? 2 : 3;
    EXPECT_EQ(expand_topology(mode, v).size(), element_count(mode, v.size()) * corners) << mode;
    for (std::size_t n = 0; n < 3; ++n)
      EXPECT_NO_FATAL_FAILURE(expand_topology(mode, Indices(v.begin(), v.begin() + n)));
  }
}

TEST(Topology, DropsDegenerateElements) {
  using Indices = std::vector<std::uint32_t>;
  EXPECT_EQ(expand_topology(4, {0, 0, 1, 0, 1, 2}), (Indices{0, 1, 2}));
  // Two strips joined by repeated vertices: only their own triangles remain, windings kept.
  EXPECT_EQ(expand_topology(5, {0, 1, 2, 2, 3, 3, 4, 5}), (Indices{0, 1, 2, 3, 5, 4}));
  EXPECT_EQ(expand_topology(2, {7}), Indices());
}

}  // namespace
}  // namespace furnace::testing
