#include "renderer/assets/zip_reader.hpp"

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>

#include <random>

namespace furnace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct File {
  std::string name, bytes;
  int flags = 0;
  std::uint32_t attributes = 0;
  std::int64_t claimed_bytes = -1;  // -1: its own
};

void put(std::string& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += char(value >> (8 * i) & 255);
}

std::string deflated(const std::string& bytes) {
  std::string out(bytes.size() + 100, '\0');
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(9);
  out.resize(libdeflate_deflate_compress(compressor, bytes.data(), bytes.size(), out.data(), out.size()));
  libdeflate_free_compressor(compressor);
  return out;
}

// As APPNOTE 4.3 has it. What is longer than 20 bytes is deflated.
std::string zip(const std::vector<File>& files) {
  std::string out, directory;
  for (const File& file : files) {
    const bool deflate = file.bytes.size() > 20;
    const std::string packed = deflate ? deflated(file.bytes) : file.bytes;
    std::string common;
    put(common, 20, 2), put(common, std::uint32_t(file.flags), 2), put(common, deflate ? 8 : 0, 2);
    put(common, 0, 4), put(common, libdeflate_crc32(0, file.bytes.data(), file.bytes.size()), 4);
    put(common, std::uint32_t(packed.size()), 4);
    put(common, std::uint32_t(file.claimed_bytes < 0 ? std::int64_t(file.bytes.size()) : file.claimed_bytes),
        4);
    put(common, std::uint32_t(file.name.size()), 2), put(common, 0, 2);
    put(directory, 0x02014b50, 4), put(directory, 3 << 8 | 20, 2);
    directory += common;
    put(directory, 0, 2), put(directory, 0, 2), put(directory, 0, 2), put(directory, file.attributes, 4);
    put(directory, std::uint32_t(out.size()), 4);
    directory += file.name;
    put(out, 0x04034b50, 4);
    out += common + file.name + packed;
  }
  const std::size_t begin = out.size();
  out += directory;
  put(out, 0x06054b50, 4), put(out, 0, 4), put(out, std::uint32_t(files.size()), 2);
  put(out, std::uint32_t(files.size()), 2), put(out, std::uint32_t(directory.size()), 4);
  put(out, std::uint32_t(begin), 4), put(out, 0, 2);
  return out;
}

ErrorCode code_of(const std::string& bytes, const ZipLimits& limits = {}) {
  try {
    const ZipReader archive{Blob(bytes), limits};
    for (const std::string& name : archive.names()) archive.read(name);
  } catch (const Error& error) {
    return error.code;
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorCode::kInternal;
}

const std::string kLong(5000, 'a');

TEST(ZipReader, ReadsWhatIsStoredAndWhatIsDeflated) {
  const ZipReader archive{Blob(zip({{"b/long.txt", kLong}, {"a.txt", "short"}, {"b/", ""}}))};
  EXPECT_THAT(archive.names(), ElementsAre("a.txt", "b/long.txt"));
  EXPECT_EQ(archive.read("a.txt")->text(), "short");
  EXPECT_EQ(archive.read("b/long.txt")->text(), kLong);
  EXPECT_FALSE(archive.read("b/"));
}

TEST(ZipReader, RefusesWhatMayMeanSomethingElse) {
  for (const char* name : {"/etc/passwd", "../a", "a/../b", "a//b", ".", "./a", "a\\b", "C:a", ""})
    EXPECT_EQ(code_of(zip({{name, "x"}})), ErrorCode::kUnprocessable) << name;
  EXPECT_EQ(code_of(zip({{"link", "/etc/passwd", 0, 0120777u << 16}})), ErrorCode::kUnprocessable);
  EXPECT_EQ(code_of(zip({{"secret", "x", 1}})), ErrorCode::kUnprocessable);
  EXPECT_EQ(code_of(zip({{"a", "1"}, {"a", "2"}})), ErrorCode::kUnprocessable);
  EXPECT_EQ(code_of("PK"), ErrorCode::kUnprocessable);
}

TEST(ZipReader, HoldsItsLimits) {
  EXPECT_EQ(code_of(zip({{"a", ""}, {"b", ""}, {"c", ""}}), {2}), ErrorCode::kTooLarge);
  EXPECT_EQ(code_of(zip({{"a", kLong}}), {10, 4999}), ErrorCode::kTooLarge);
  EXPECT_EQ(code_of(zip({{"a", kLong}}), {10, 1 << 20, 10, 100}), ErrorCode::kTooLarge);
  // It claims less than it inflates to, and more than there is.
  EXPECT_EQ(code_of(zip({{"a", kLong, 0, 0, 100}})), ErrorCode::kUnprocessable);
  EXPECT_EQ(code_of(zip({{"a", kLong, 0, 0, 5001}})), ErrorCode::kUnprocessable);
  EXPECT_EQ(code_of(zip({{"a", kLong, 0, 0, 2'000'000'000}})), ErrorCode::kTooLarge);
}

TEST(ZipReader, AnyDamageIsAnErrorOrChangesNothing) {
  const std::string whole = zip({{"model.gltf", kLong}, {"b.bin", "short"}});
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_EQ(code_of(whole.substr(0, size)), ErrorCode::kUnprocessable) << size;
  std::mt19937 random(7);
  for (int i = 0; i < 4000; ++i) {
    std::string bytes = whole;
    for (int change = 0; change <= i % 3; ++change)
      bytes[random() % bytes.size()] ^= char(1u << random() % 8);
    try {
      const ZipReader archive{Blob(bytes)};
      for (const std::string& name : archive.names()) {
        const Blob file = *archive.read(name);
        const std::string_view text = file.text();
        EXPECT_TRUE(text == kLong || text == "short" || text.empty());
      }
    } catch (const Error& error) {
      EXPECT_TRUE(error.code == ErrorCode::kUnprocessable || error.code == ErrorCode::kTooLarge);
    }
  }
}

TEST(ZipModel, IsTheShallowestOne) {
  const auto model = [](const std::vector<File>& files) { return model_in(ZipReader{Blob(zip(files))}); };
  EXPECT_EQ(model({{"chair/chair.gltf", "x"}, {"chair/parts/leg.obj", "x"}, {"readme.txt", "x"}}),
            "chair/chair.gltf");
  EXPECT_EQ(model({{"__MACOSX/._a.glb", "x"}, {"d/e/a.glb", "x"}}), "d/e/a.glb");
  EXPECT_THROW(model({{"a.txt", "x"}}), Error);
  try {
    model({{"a.glb", "x"}, {"b.obj", "x"}});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    EXPECT_THAT(error.message, HasSubstr("a.glb, b.obj"));
  }
}

TEST(ZipModel, IsFoundByEveryReference) {
  const std::string gltf = R"({"asset":{"version":"2.0"},"buffers":[{"uri":"bin/a.bin","byteLength":1}]})";
  const Blob archive(zip({{"m/a.gltf", gltf}, {"m/bin/a.bin", "inside"}}));
  FileAssets files({}, 0, 0);
  const AssetResolver assets(files, {{"zip", archive}}, {}, {}, [&](const std::string& id) {
    return id == "known" ? std::optional(archive) : std::nullopt;
  });
  for (const char* reference : {"part:zip", "asset:known", "asset:known/m/a.gltf"}) {
    const auto bundle = assets.read_model(reference, "/scene/model");
    EXPECT_EQ(bundle->document.text(), gltf) << reference;
    ASSERT_TRUE(bundle->siblings.contains("bin/a.bin")) << reference;
    EXPECT_EQ(bundle->siblings.at("bin/a.bin").text(), "inside");
  }
  EXPECT_EQ(assets.read("asset:known/m/bin/a.bin", "/x").text(), "inside");
  EXPECT_EQ(assets.read("asset:known", "/x").hash(), archive.hash());
  for (const char* missing : {"asset:known/none", "asset:unknown"}) {
    try {
      assets.read(missing, "/x");
      ADD_FAILURE() << missing;
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kNotFound);
      EXPECT_EQ(error.pointer, "/x");
    }
  }
}

// OBJ files name textures as they lay on another machine; a glTF says exactly where they are.
TEST(ZipModel, OfAnObjFindsItsTexturesAnywhere) {
  FileAssets none({}, 0, 1 << 20);
  const auto siblings_of = [&](const std::vector<File>& files) {
    const AssetResolver resolver(none, {{"m", Blob(zip(files))}}, {});
    std::map<std::string, std::string> found;
    const auto bundle = resolver.read_model("part:m", "/scene/model");
    for (const auto& [name, blob] : bundle->siblings) found.emplace(name, blob.text());
    return found;
  };
  const File model{"source/a.obj", "mtllib A.mtl\nv 0 0 0\n"};
  const File materials{"source/a.mtl", "newmtl m\nmap_Kd C:\\me\\Wood.PNG\n"};
  const std::map<std::string, std::string> both = {{"A.mtl", materials.bytes}, {"Wood.PNG", "wood"}};
  EXPECT_EQ(siblings_of({model, materials, {"textures/wood.png", "wood"}}), both);
  // Which of two is meant nobody knows, but what lies beside is.
  EXPECT_EQ(siblings_of({model, materials, {"t/wood.png", "1"}, {"u/wood.png", "2"}}).size(), 1u);
  EXPECT_EQ(siblings_of({model, materials, {"t/wood.png", "1"}, {"source/Wood.PNG", "wood"}}), both);
  const File gltf{"source/a.gltf", R"({"asset":{"version":"2.0"},"images":[{"uri":"wood.png"}]})"};
  EXPECT_TRUE(siblings_of({gltf, {"textures/wood.png", "wood"}}).empty());
}

TEST(NamedFiles, ComeBeforeWhatLiesBeside) {
  const std::string gltf = R"({"asset":{"version":"2.0"},"buffers":[{"uri":"a.bin","byteLength":1}]})";
  FileAssets files({}, 0, 0);
  const AssetResolver assets(files, {{"m", Blob(gltf)}, {"a.bin", Blob(std::string("part"))}}, {});
  EXPECT_EQ(assets.read_model("part:m", "")->siblings.at("a.bin").text(), "part");
  const NamedFiles named = {{"a.bin", Blob(std::string("named"))}};
  EXPECT_EQ(assets.read_model("part:m", "", named)->siblings.at("a.bin").text(), "named");
}

}  // namespace
}  // namespace furnace
