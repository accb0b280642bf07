#include "renderer/assets/asset_resolver.hpp"

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <thread>
#include <vector>

namespace furnace {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr std::int64_t kCacheBytes = 1 << 20, kMaxFileBytes = 1 << 16;
const std::string kPlace = "/scene/model";  // in the request

template <class Body>
Error error_of(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

// root/ holds the assets; secret.txt lies beside it.
class AssetTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "furnace_assets_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    base_ = name;
    root_ = base_ / "root";
    fs::create_directories(root_ / "models");
    write("models/box.bin", "box");
    write_file_atomically(base_ / "secret.txt", "secret");
  }
  void TearDown() override { fs::remove_all(base_); }

  void write(const std::string& relative, const std::string& bytes) {
    write_file_atomically(root_ / relative, bytes);
  }
  FileAssets files() const { return FileAssets({root_}, kCacheBytes, kMaxFileBytes); }

  fs::path base_, root_;
};

TEST_F(AssetTest, ReadsFilesBelowItsRoots) {
  fs::create_directories(base_ / "second");
  write_file_atomically(base_ / "second" / "only_here", "2");
  write_file_atomically(base_ / "second" / "models",
                        "hidden by the first root's folder? no: that is no file");
  FileAssets assets({root_, base_ / "second", base_ / "absent"}, kCacheBytes, kMaxFileBytes);
  EXPECT_EQ(assets.read("models/box.bin", kPlace).text(), "box");
  EXPECT_EQ(assets.read("./models//box.bin", kPlace).text(), "box");
  EXPECT_EQ(assets.read("only_here", kPlace).text(), "2");
  EXPECT_THAT(assets.read("models", kPlace).text(), HasSubstr("no file"));
}

TEST_F(AssetTest, ReadsLinksThatStayInside) {
  fs::create_symlink("models/box.bin", root_ / "link");
  fs::create_directory_symlink("models", root_ / "linked");
  FileAssets assets = files();
  EXPECT_EQ(assets.read("link", kPlace).text(), "box");
  EXPECT_EQ(assets.read("linked/box.bin", kPlace).text(), "box");
}

TEST_F(AssetTest, RefusesPathsThatClimb) {
  FileAssets assets = files();
  for (const std::string path : {"../secret.txt", "models/../../secret.txt", "models/../models/box.bin", "..",
                                 "/etc/passwd", "", "models/..", "./../secret.txt"}) {
    const Error error = error_of([&] { assets.read(path, kPlace); });
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable) << path;
    EXPECT_EQ(error.pointer, kPlace) << path;
  }
  EXPECT_EQ(error_of([&] { assets.read((base_ / "secret.txt").string(), kPlace); }).code,
            ErrorCode::kUnprocessable);
  EXPECT_EQ(error_of([&] { assets.read(std::string("models/box.bin\0.png", 19), kPlace); }).code,
            ErrorCode::kUnprocessable);
}

// What a link reaches outside looks just as what is not there at all.
TEST_F(AssetTest, TellsNothingOfWhatIsOutside) {
  fs::create_symlink(base_ / "secret.txt", root_ / "to_file");
  fs::create_symlink(base_ / "not_there", root_ / "to_nothing");
  fs::create_directory_symlink(base_, root_ / "to_folder");
  fs::create_symlink("loop", root_ / "loop");
  // Shares the beginning of the root's name without being below it.
  fs::create_directories(base_ / "root_of_another");
  write_file_atomically(base_ / "root_of_another" / "x", "secret");
  fs::create_symlink(base_ / "root_of_another" / "x", root_ / "to_neighbour");
  FileAssets assets = files();
  const auto told = [&](const std::string& name) {
    const Error error = error_of([&] { assets.read(name, kPlace); });
    EXPECT_EQ(error.code, ErrorCode::kNotFound) << name;
    EXPECT_THAT(error.message, Not(HasSubstr(base_.string())));
    std::string message = error.message;
    return message.replace(message.find(name), name.size(), "NAME");
  };
  const std::string absent = told("absent");
  for (const std::string name : {"to_file", "to_nothing", "to_folder/secret.txt", "to_folder/nothing",
                                 "to_neighbour", "loop", "models", "models/box.bin/x", "to_folder"}) {
    EXPECT_EQ(told(name), absent) << name;
  }
  ASSERT_EQ(mkfifo((root_ / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(told("pipe"), absent);
}

TEST_F(AssetTest, AnObjFindsItsMaterialsAndTheirTextures) {
  fs::create_directories(root_ / "models" / "lib");
  write("models/thing.obj", "mtllib lib\\a.mtl\nmtllib ../../secret.txt\nv 0 0 0\n");
  write("models/lib/a.mtl",
        "newmtl m\nmap_Kd /far/away/wood.png\nmap_Ke near.png\nmap_d ../../../secret.txt\n");
  write("models/lib/wood.png", "wood");
  write("models/near.png", "near");
  const auto bundle = files().read_model("models/thing.obj", kPlace, {});
  EXPECT_EQ(bundle->format, ModelFormat::kObj);
  std::map<std::string, std::string> found;
  for (const auto& [name, blob] : bundle->siblings) found[name] = blob.text().substr(0, 4);
  const std::map<std::string, std::string> expected = {
      {"lib/a.mtl", "newm"}, {"wood.png", "wood"}, {"near.png", "near"}};
  EXPECT_EQ(found, expected);

  FileAssets assets = files();
  const AssetResolver parts(
      assets,
      {{"model", Blob("v 0 0 0\nmtllib x/a.mtl\n")}, {"a.mtl", Blob("map_Kd t.png\n")}, {"t.png", Blob("t")}},
      {});
  EXPECT_EQ(parts.read_model("part:model", kPlace)->siblings.size(), 2u);
}

TEST_F(AssetTest, HonoursTheLimitOfSize) {
  write("large", std::string(kMaxFileBytes + 1, 'x'));
  write("fits", std::string(kMaxFileBytes, 'x'));
  FileAssets assets = files();
  const Error error = error_of([&] { assets.read("large", kPlace); });
  EXPECT_EQ(error.code, ErrorCode::kTooLarge);
  EXPECT_EQ(error.pointer, kPlace);
  EXPECT_EQ(assets.read("fits", kPlace).size(), static_cast<std::size_t>(kMaxFileBytes));
}

TEST_F(AssetTest, ReadsAFileAgainOnlyWhenItChanged) {
  FileAssets assets = files();
  const Blob first = assets.read("models/box.bin", kPlace);
  EXPECT_EQ(assets.read("models/box.bin", kPlace).bytes().data(), first.bytes().data()) << "was read twice";
  write("models/box.bin", "BOX");  // the same size, another inode
  EXPECT_EQ(assets.read("models/box.bin", kPlace).text(), "BOX");
  EXPECT_EQ(first.text(), "box");
}

TEST_F(AssetTest, ServesManyThreads) {
  FileAssets assets = files();
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 50; ++i) wrong += assets.read("models/box.bin", kPlace).size() != 3;
      });
    }
    threads.emplace_back([&] {
      for (int i = 0; i < 10; ++i) write("models/box.bin", i % 2 ? "abc" : "xyz");
    });
  }
  EXPECT_EQ(wrong, 0);
}

std::string gltf(const std::vector<std::string>& buffer_uris,
                 const std::vector<std::string>& image_uris = {}) {
  const auto list = [](const std::string& name, const std::vector<std::string>& uris,
                       const std::string& rest) {
    std::string text;
    for (const std::string& uri : uris)
      text += (text.empty() ? "" : ",") + ("{\"uri\":\"" + uri + "\"" + rest + "}");
    return uris.empty() ? std::string() : ",\"" + name + "\":[" + text + "]";
  };
  return "{\"asset\":{\"version\":\"2.0\"}" + list("buffers", buffer_uris, ",\"byteLength\":3") +
         list("images", image_uris, "") + "}";
}

TEST_F(AssetTest, ReadsAModelWithWhatLiesBesideIt) {
  fs::create_directories(root_ / "models" / "textures");
  write("models/textures/a b.png", "png");
  write("models/box.gltf", gltf({"box.bin", "missing.bin"}, {"textures/a%20b.png"}));
  FileAssets assets = files();
  const auto bundle = assets.read_model("models/box.gltf", kPlace, {});
  EXPECT_THAT(bundle->document.text(), HasSubstr("box.bin"));
  ASSERT_EQ(bundle->siblings.size(), 2u) << "what is missing is left out";
  EXPECT_EQ(bundle->siblings.at("box.bin").text(), "box");
  EXPECT_EQ(bundle->siblings.at("textures/a b.png").text(), "png");

  EXPECT_EQ(assets.read_model("models/box.gltf", kPlace, {})->hash, bundle->hash);
  write("models/box.bin", "BOX");
  EXPECT_NE(assets.read_model("models/box.gltf", kPlace, {})->hash, bundle->hash)
      << "a changed sibling is another model";
}

TEST_F(AssetTest, ModelsDoNotReachOutside) {
  FileAssets assets = files();
  for (const std::string uri : {"../../secret.txt", "%2e%2e/%2e%2e/secret.txt", "/etc/passwd",
                                "file:///etc/passwd", "http://localhost/x.bin"}) {
    write("models/bad.gltf", gltf({uri}));
    EXPECT_EQ(error_of([&] { assets.read_model("models/bad.gltf", kPlace, {}); }).code,
              ErrorCode::kUnprocessable)
        << uri;
  }
  fs::create_symlink(base_ / "secret.txt", root_ / "models" / "link.bin");
  write("models/link.gltf", gltf({"link.bin"}));
  EXPECT_TRUE(assets.read_model("models/link.gltf", kPlace, {})->siblings.empty());
}

TEST_F(AssetTest, SaysWhichModelIsBroken) {
  write("models/broken.gltf", "{");
  FileAssets assets = files();
  const Error error = error_of([&] { assets.read_model("models/broken.gltf", kPlace, {}); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.context, testing::Contains(kPlace));
}

class ResolverTest : public AssetTest {
 protected:
  AssetResolver resolver(std::map<std::string, std::string> parts) {
    std::map<std::string, Blob> blobs;
    for (auto& [name, bytes] : parts) blobs.emplace(name, Blob(bytes));
    return AssetResolver(files_, std::move(blobs), ImportLimits{});
  }

  FileAssets files_{{}, 0, 0};

  void SetUp() override {
    AssetTest::SetUp();
    files_ = files();
  }
};

TEST_F(ResolverTest, KnowsThreeSchemes) {
  const AssetResolver assets = resolver({{"sky", "part"}});
  EXPECT_EQ(assets.read("part:sky", kPlace).text(), "part");
  EXPECT_EQ(assets.read("file:models/box.bin", kPlace).text(), "box");
  EXPECT_EQ(assets.read("data:application/octet-stream;base64,aGk=", kPlace).text(), "hi");
  EXPECT_EQ(assets.read("data:,a%20b", kPlace).text(), "a b");
}

TEST_F(ResolverTest, PointsAtWhatIsWrong) {
  const AssetResolver assets = resolver({{"sky", "part"}});
  const auto expect = [&](const std::string& reference, ErrorCode code) {
    const Error error = error_of([&] { assets.read(reference, kPlace); });
    EXPECT_EQ(error.code, code) << reference;
    EXPECT_EQ(error.pointer, kPlace) << reference;
  };
  expect("part:moon", ErrorCode::kNotFound);
  expect("part:", ErrorCode::kNotFound);
  expect("file:absent", ErrorCode::kNotFound);
  expect("asset:sha256-00", ErrorCode::kNotFound);
  expect("file:../secret.txt", ErrorCode::kUnprocessable);
  for (const std::string reference : {"", "sky", "http://localhost/x", "FILE:models/box.bin"}) {
    expect(reference, ErrorCode::kUnprocessable);
  }
  for (const std::string data : {"data:", "data:;base64", "data:;base64,a", "data:;base64,aGk",
                                 "data:;base64,aG k=", "data:;base64,aGk=aGk=", "data:;base64,a===",
                                 "data:;base64,aGl=", "data:;base64,aG-_", "data:,%4", "data:,%zz"}) {
    expect(data, ErrorCode::kUnprocessable);
  }
}

TEST_F(ResolverTest, FindsSiblingsAmongTheParts) {
  const auto siblings = [&](const std::string& document, std::map<std::string, std::string> parts) {
    parts["model"] = document;
    return resolver(parts).read_model("part:model", kPlace)->siblings;
  };
  const std::string document = gltf({"data/box.bin"}, {"a%20b.png"});
  // By the whole URI first, though another part has the right last segment.
  auto found = siblings(document, {{"data/box.bin", "whole"}, {"box.bin", "segment"}, {"a b.png", "png"}});
  EXPECT_EQ(found.at("data/box.bin").text(), "whole");
  EXPECT_EQ(found.at("a b.png").text(), "png");
  // By the last segment of either name.
  found = siblings(document, {{"box.bin", "segment"}, {"textures/a b.png", "png"}});
  EXPECT_EQ(found.at("data/box.bin").text(), "segment");
  EXPECT_EQ(found.at("a b.png").text(), "png");
  EXPECT_TRUE(siblings(document, {}).empty());
}

TEST_F(ResolverTest, RefusesToGuessBetweenParts) {
  const std::string document = gltf({"box.bin"});
  const auto read = [&](std::map<std::string, std::string> parts) {
    parts["model"] = document;
    return resolver(parts).read_model("part:model", kPlace);
  };
  const Error error = error_of([&] { read({{"a/box.bin", "1"}, {"b/box.bin", "2"}}); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_EQ(error.pointer, kPlace);
  EXPECT_THAT(error.message, HasSubstr("box.bin"));
  EXPECT_EQ(read({{"a/box.bin", "1"}, {"b/box.bin", "1"}})->siblings.size(), 1u)
      << "the same file twice is no doubt";
}

TEST_F(ResolverTest, PartsDoNotReachFiles) {
  const AssetResolver assets = resolver({{"model", gltf({"models/box.bin", "box.bin"})}});
  EXPECT_TRUE(assets.read_model("part:model", kPlace)->siblings.empty());
}

TEST_F(ResolverTest, RemoteFilesAreAskedForByTheirUrl) {
  const Error off = error_of([&] { resolver({}).read("https://example.com/a.png", kPlace); });
  EXPECT_EQ(off.code, ErrorCode::kUnprocessable);
  EXPECT_EQ(off.pointer, kPlace);
  EXPECT_THAT(off.message, HasSubstr("remote-allow"));

  std::vector<std::string> asked;
  FileAssets files({root_}, kCacheBytes, kMaxFileBytes);
  const AssetResolver assets(
      files, {{"b.bin", Blob("part")}}, {}, {}, {}, [&](const std::string& url, const std::string& relative) {
        asked.push_back(url + " " + relative);
        if (relative == "missing.bin") return std::optional<Blob>();
        return std::optional(
            Blob(relative.empty() ? gltf({"a.bin", "b.bin", "missing.bin"}) : "far " + relative));
      });
  const auto model = assets.read_model("HTTPS://example.com/m.gltf?v=1", kPlace);
  EXPECT_EQ(model->siblings.at("a.bin").text(), "far a.bin");
  EXPECT_EQ(model->siblings.at("b.bin").text(), "part") << "what the request brings goes first";
  EXPECT_FALSE(model->siblings.contains("missing.bin"));
  EXPECT_THAT(asked,
              testing::ElementsAre("HTTPS://example.com/m.gltf?v=1 ", "HTTPS://example.com/m.gltf?v=1 a.bin",
                                   "HTTPS://example.com/m.gltf?v=1 missing.bin"));
}

TEST_F(ResolverTest, ReadsModelsOfEveryScheme) {
  write("models/box.gltf", gltf({"box.bin"}));
  const AssetResolver assets = resolver({{"box.bin", "part"}, {"model", gltf({"box.bin"})}});
  EXPECT_EQ(assets.read_model("file:models/box.gltf", kPlace)->siblings.at("box.bin").text(), "box");
  EXPECT_EQ(assets.read_model("part:model", kPlace)->siblings.at("box.bin").text(), "part");
  EXPECT_EQ(assets.read_model("data:," + gltf({}), kPlace)->siblings.size(), 0u);
  EXPECT_EQ(error_of([&] { assets.read_model("part:absent", kPlace); }).code, ErrorCode::kNotFound);
  EXPECT_EQ(error_of([&] { assets.read_model("gopher:x", kPlace); }).code, ErrorCode::kUnprocessable);
}

}  // namespace
}  // namespace furnace
