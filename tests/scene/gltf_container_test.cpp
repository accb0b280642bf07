#include "renderer/scene/gltf_container.hpp"

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {
namespace {

void append_word(std::string& bytes, std::uint32_t word) {
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

std::string chunk(const std::string& type, std::string payload, char padding) {
  payload.resize((payload.size() + 3) / 4 * 4, padding);
  std::string bytes;
  append_word(bytes, static_cast<std::uint32_t>(payload.size()));
  return bytes + type + payload;
}

std::string glb(const std::string& chunks, std::uint32_t version = 2) {
  std::string bytes = "glTF";
  append_word(bytes, version);
  append_word(bytes, static_cast<std::uint32_t>(12 + chunks.size()));
  return bytes + chunks;
}

const std::string kBin("BIN\0", 4);

// The triangle of triangle_builder() with its buffer in the BIN chunk.
std::string triangle_glb() {
  const GltfBuilder builder = triangle_builder();
  Json document = builder.json;
  document["buffers"] = Json::array({{{"byteLength", builder.bytes.size()}}});
  return glb(chunk("JSON", document.dump(), ' ') + chunk(kBin, builder.bytes, '\0'));
}

Scene import_bytes(const std::string& bytes) {
  ModelBundle bundle;
  bundle.document = Blob(bytes);
  bundle.seal();
  return import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
}

TEST(GlbContainer, BuffersComeFromTheBinChunk) {
  const Scene scene = import_bytes(triangle_glb());
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0]->positions[1], glm::vec3(1, 0, 0));
}

TEST(GlbContainer, EveryTruncationIsRefused) {
  const std::string whole = triangle_glb();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto error = error_of([&] { import_bytes(whole.substr(0, size)); });
    ASSERT_TRUE(error) << size;
    EXPECT_EQ(error->code, ErrorCode::kUnprocessable) << size;
  }
}

TEST(GlbContainer, UnknownChunksAreSkippedAndBytesAfterTheEndIgnored) {
  std::string whole = triangle_glb();
  const auto length = static_cast<std::uint32_t>(whole.size() + 12);
  whole += chunk("XTRA", "tail", ' ');
  std::memcpy(whole.data() + 8, &length, sizeof length);
  EXPECT_EQ(import_bytes(whole + "junk").meshes.size(), 1u);
}

TEST(GlbContainer, OrderAndVersionAreChecked) {
  const std::string json = chunk("JSON", R"({"asset":{"version":"2.0"}})", ' ');
  EXPECT_FALSE(error_of([&] { import_bytes(glb(json)); }));
  EXPECT_TRUE(error_of([&] { import_bytes(glb(json, 1)); }));
  EXPECT_TRUE(error_of([&] { import_bytes(glb(chunk(kBin, "1234", ' ') + json)); }));
  EXPECT_TRUE(
      error_of([&] { import_bytes(glb(json + chunk(kBin, "1234", ' ') + chunk(kBin, "1234", ' '))); }));
  EXPECT_TRUE(error_of([&] { import_bytes(glb(json + json)); }));
  EXPECT_TRUE(error_of([&] { import_bytes(glb("")); }));
  std::string unaligned = json;
  unaligned.insert(unaligned.end(), ' ');
  ++unaligned[0];
  EXPECT_TRUE(error_of([&] { import_bytes(glb(unaligned)); }));
}

// RFC 4648, section 10.
TEST(DataUri, DecodesTheTestVectorsOfBase64) {
  const std::vector<std::pair<std::string, std::string>> vectors{{"", ""},
                                                                 {"Zg==", "f"},
                                                                 {"Zm8=", "fo"},
                                                                 {"Zm9v", "foo"},
                                                                 {"Zm9vYg==", "foob"},
                                                                 {"Zm9vYmE=", "fooba"},
                                                                 {"Zm9vYmFy", "foobar"}};
  for (const auto& [encoded, plain] : vectors) {
    EXPECT_EQ(decode_data_uri("data:application/octet-stream;base64," + encoded, "/u"), plain);
  }
  EXPECT_EQ(decode_data_uri("DATA:;BASE64,+/8=", "/u"), "\xFB\xFF");
  EXPECT_EQ(decode_data_uri("data:,a%20b", "/u"), "a b");
}

TEST(DataUri, RefusesWhatIsNotStrictBase64) {
  for (const std::string payload :
       {"Zg", "Zg=", "Z===", "=", "Zm9v Zg==", "Zm-_", "Zh==", "Zg==Zg==", "Zm9v\n"}) {
    const auto error = error_of([&] { decode_data_uri("data:x/y;base64," + payload, "/u"); });
    ASSERT_TRUE(error) << payload;
    EXPECT_EQ(error->pointer, "/u");
  }
  EXPECT_TRUE(error_of([] { decode_data_uri("data:x/y;base64", "/u"); }));
}

TEST(RelativeUri, IsPercentDecoded) {
  EXPECT_EQ(decode_relative_uri("a%20b/%C3%A9.bin", "/u"), "a b/\xC3\xA9.bin");
  EXPECT_EQ(decode_relative_uri("./x..y/...bin", "/u"), "./x..y/...bin");
}

TEST(RelativeUri, NeverLeavesItsFolder) {
  for (const std::string uri :
       {"http://a/b", "file:b", "C:/b", "/etc/passwd", "%2Fetc/passwd", "../b", "a/../../b", "a/%2e%2E/b",
        "..", "\\\\host\\b", "a\\..\\b", "a%00b", "a%1", "a%zz", "a\nb", ""}) {
    const auto error = error_of([&] { decode_relative_uri(uri, "/u"); });
    ASSERT_TRUE(error) << uri;
    EXPECT_EQ(error->code, ErrorCode::kUnprocessable);
    EXPECT_EQ(error->pointer, "/u");
  }
}

TEST(ExternalUris, AreListedOnceInOrder) {
  const std::string json = R"({"asset":{"version":"2.0"},
    "buffers":[{"byteLength":1,"uri":"b%20c.bin"},{"byteLength":1,"uri":"data:;base64,AA=="},{"byteLength":1}],
    "images":[{"uri":"z.png"},{"uri":"a.png"},{"uri":"z.png"}]})";
  EXPECT_EQ(gltf_external_uris(Blob(json), {}), (std::vector<std::string>{"b c.bin", "z.png", "a.png"}));
}

TEST(ModelBundle, HashCoversEveryFileAndItsName) {
  const auto hash_of = [](const std::string& name, const std::string& text) {
    ModelBundle bundle;
    bundle.document = Blob(std::string("{}"));
    bundle.siblings[name] = Blob(text);
    bundle.seal();
    return bundle.hash;
  };
  EXPECT_EQ(hash_of("a", "x"), hash_of("a", "x"));
  EXPECT_NE(hash_of("a", "x"), hash_of("b", "x"));
  EXPECT_NE(hash_of("a", "x"), hash_of("a", "y"));
}

}  // namespace
}  // namespace furnace::testing
