// Uploads through the dispatcher, bodies passed on as the HTTP server does it.
#include "server/asset_routes.hpp"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/http/fake_painter.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/base/error.hpp"

namespace furnace {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kEmptyModel = R"({"asset":{"version":"2.0"}})";

std::string hex_of(std::string_view text) {
  return hash_bytes(std::as_bytes(std::span(text))).hex();
}

class AssetRoutesTest : public ::testing::Test {
 protected:
  explicit AssetRoutesTest(bool keeps = true) {
    if (keeps) {
      const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
      folder_ = fs::path(::testing::TempDir()) / (std::string("asset_routes_") + test->name());
    }
    fs::remove_all(folder_);
    AssetStoreConfig config;
    config.folder = folder_;
    config.largest_bytes = 1000;
    store_ = std::make_unique<AssetStore>(config);
    const api::Capabilities capabilities;
    Doors doors{service_, admission_,   files_, decode::in_process_decoder(), environments_, readiness_,
                metrics_, capabilities, 4};
    doors.assets = store_.get();
    doors_ = std::make_unique<Doors>(std::move(doors));
    dispatcher_ = std::make_unique<Dispatcher>(public_routes(*doors_, true), metrics_);
  }
  ~AssetRoutesTest() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  Reply send(std::string method, std::string path, std::string body = {},
             std::map<std::string, std::string, HeaderLess> headers = {}) {
    Request request;
    request.method = std::move(method);
    request.path = std::move(path);
    request.headers = std::move(headers);
    const Incoming incoming = dispatcher_->receive(request);
    was_unwanted_ = incoming.is_unwanted;
    request.sink = incoming.sink;
    if (request.sink) {
      request.sink->take(body);
    } else if (!was_unwanted_) {
      request.body = std::move(body);
    }
    return dispatcher_->handle(request);
  }
  Reply render(const std::string& document) {
    return send("POST", "/v1/renders", document, {{"Content-Type", "application/json"}});
  }
  static std::string header(const Reply& reply, std::string_view name) {
    for (const auto& [key, value] : reply.headers) {
      if (key == name) return value;
    }
    return "(none)";
  }

  fs::path folder_;
  testing::FakePainter fake_;
  WorkerPool pool_{1};
  Admission admission_{1, 0};
  RenderCache renders_{{1 << 20, {}, 0}};
  RenderService service_{fake_.painter(), admission_, pool_, renders_};
  FileAssets files_{{}, 0, 1 << 20};
  Metrics metrics_{"test"};
  Readiness readiness_{[](const Deadline&) { return true; }, std::chrono::seconds(1)};
  EnvironmentRegistry environments_{
      [](const EnvironmentSpec&, const Deadline&) { return EnvironmentAnswer{}; },
      admission_,
      pool_,
      decode::in_process_decoder(),
      {}};
  std::unique_ptr<AssetStore> store_;
  std::unique_ptr<Doors> doors_;
  std::unique_ptr<Dispatcher> dispatcher_;
  bool was_unwanted_ = false;
};

class NoAssetRoutesTest : public AssetRoutesTest {
 protected:
  NoAssetRoutesTest() : AssetRoutesTest(false) {}
};

TEST_F(AssetRoutesTest, PostNamesTheAsset) {
  const Reply made = send("POST", "/v1/assets", "hello", {{"Content-Type", "image/png; x=y"}});
  EXPECT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(header(made, "Location"), "/v1/assets/" + hex_of("hello"));
  EXPECT_THAT(made.body, HasSubstr("\"id\": \"asset:sha256-" + hex_of("hello") + "\", \"bytes\": 5"));
  EXPECT_THAT(made.body, HasSubstr("\"mediaType\": \"image/png\""));
  EXPECT_EQ(send("POST", "/v1/assets", "hello").status, 200);
  EXPECT_EQ(send("POST", "/v1/assets").status, 400);
}

TEST_F(AssetRoutesTest, PutVerifiesAndIsAnsweredFromTheHeadWhenItIsThere) {
  const std::string path = "/v1/assets/" + hex_of("hello");
  EXPECT_EQ(send("PUT", path, "other").status, 422);
  EXPECT_EQ(send("GET", path).status, 404);
  EXPECT_EQ(send("PUT", path, "hello").status, 201);
  EXPECT_FALSE(was_unwanted_);
  EXPECT_EQ(send("PUT", path, "hello").status, 200);
  EXPECT_TRUE(was_unwanted_);
  for (const char* wrong : {"abc", "../x", "sha256-00"})
    EXPECT_EQ(send("PUT", std::string("/v1/assets/") + wrong, "x").status, 400) << wrong;
}

TEST_F(AssetRoutesTest, GetHeadDelete) {
  const std::string path = "/v1/assets/" + hex_of("hello");
  send("PUT", path, "hello");
  const Reply got = send("GET", path);
  EXPECT_EQ(got.status, 200);
  ASSERT_NE(got.file, nullptr);
  EXPECT_EQ(got.file->read(0, 100), "hello");
  EXPECT_EQ(got.media_type, "application/octet-stream");
  EXPECT_EQ(header(got, "ETag"), '"' + hex_of("hello") + '"');
  EXPECT_EQ(header(got, "Cache-Control"), "private, max-age=31536000, immutable");
  EXPECT_EQ(send("HEAD", path).file->bytes, 5);
  EXPECT_EQ(send("GET", path, "", {{"If-None-Match", header(got, "ETag")}}).status, 304);
  EXPECT_EQ(send("DELETE", path).status, 204);
  for (const char* method : {"GET", "HEAD", "DELETE"}) EXPECT_EQ(send(method, path).status, 404) << method;
}

TEST_F(AssetRoutesTest, PiecesBecomeTheAsset) {
  const std::string path = "/v1/assets/" + hex_of("hello, world");
  const auto piece = [&](std::string range, std::string bytes) {
    return send("PUT", path, std::move(bytes), {{"Content-Range", "bytes " + range}});
  };
  EXPECT_EQ(header(piece("*/12", ""), "Upload-Offset"), "0");
  const Reply begun = piece("0-4/12", "hello");
  EXPECT_EQ(begun.status, 202) << begun.body;
  EXPECT_EQ(header(begun, "Upload-Offset"), "5");
  EXPECT_EQ(header(begun, "Range"), "bytes=0-4");
  EXPECT_THAT(begun.body, HasSubstr("\"receivedBytes\": 5, \"bytes\": 12"));
  EXPECT_EQ(send("GET", path).status, 404);

  // A piece that breaks off leaves what came.
  EXPECT_EQ(header(piece("5-9/12", ", "), "Upload-Offset"), "7");
  for (const char* wrong : {"0-4/12", "5-11/12", "8-11/12"}) {
    const Reply reply = piece(wrong, "xxxxx");
    EXPECT_EQ(reply.status, 409) << wrong;
    EXPECT_EQ(header(reply, "Upload-Offset"), "7");
    EXPECT_TRUE(was_unwanted_);
  }
  EXPECT_EQ(piece("7-11/12", "world").status, 201);
  EXPECT_EQ(send("GET", path).file->read(0, 100), "hello, world");
  EXPECT_EQ(piece("0-4/12", "hello").status, 200) << "it is there";
  EXPECT_TRUE(fs::is_empty(folder_ / "partial"));
}

TEST_F(AssetRoutesTest, PiecesOfSomethingElseAreForgotten) {
  const std::string path = "/v1/assets/" + hex_of("hello");
  const auto piece = [&](std::string range, std::string bytes) {
    return send("PUT", path, std::move(bytes), {{"Content-Range", std::move(range)}});
  };
  EXPECT_EQ(piece("bytes 0-4/5", "jello").status, 422);
  EXPECT_EQ(header(piece("bytes */5", ""), "Upload-Offset"), "0");
  EXPECT_EQ(piece("bytes 0-2/2000", "abc").status, 413);
  for (const char* wrong : {"bytes 0-4", "bytes 4-0/5", "bytes 0-5/5", "items 0-4/5", "bytes 0-4/*"})
    EXPECT_EQ(piece(wrong, "hello").status, 400) << wrong;
  EXPECT_EQ(piece("bytes 0-4/5", "hello").status, 201);
}

TEST_F(AssetRoutesTest, PiecesLongerThanTheirRangeAreRefused) {
  Request request;
  request.method = "PUT";
  request.path = "/v1/assets/" + hex_of("hello");
  request.headers = {{"Content-Range", "bytes 0-1/5"}};
  const Incoming incoming = dispatcher_->receive(request);
  ASSERT_NE(incoming.sink, nullptr);
  EXPECT_THROW(incoming.sink->take("hello"), Error);
  const Reply meanwhile = send("PUT", request.path, "", {{"Content-Range", "bytes 0-4/5"}});
  EXPECT_EQ(meanwhile.status, 409);
  EXPECT_THAT(meanwhile.body, HasSubstr("just now"));
}

TEST_F(AssetRoutesTest, FormsHaveSeveralFiles) {
  const std::string form =
      "--B\r\nContent-Disposition: form-data; name=model; filename=quad.gltf\r\nContent-Type: "
      "model/gltf+json\r\n"
      "\r\n{}\r\n--B\r\nContent-Disposition: form-data; name=bin\r\n\r\nhello\r\n--B--";
  const std::map<std::string, std::string, HeaderLess> type = {
      {"Content-Type", "multipart/form-data; boundary=B"}};
  const Reply made = send("POST", "/v1/assets", form, type);
  EXPECT_EQ(made.status, 201) << made.body;
  EXPECT_THAT(made.body, HasSubstr(R"({"assets": [{"part": "model", "id": "asset:sha256-)" + hex_of("{}")));
  EXPECT_THAT(made.body,
              HasSubstr(R"("mediaType": "model/gltf+json", "name": "quad.gltf"}, {"part": "bin")"));
  EXPECT_EQ(send("GET", "/v1/assets/" + hex_of("hello")).status, 200);
  EXPECT_EQ(send("POST", "/v1/assets", form, type).status, 200);

  EXPECT_EQ(send("POST", "/v1/assets", "--B--", type).status, 400);
  EXPECT_EQ(send("POST", "/v1/assets", "hello", {{"Content-Type", "multipart/form-data"}}).status, 400);
  std::string cut = form;
  cut.resize(cut.size() - 20);
  cut.replace(cut.find("{}"), 2, "{ }");
  EXPECT_EQ(send("POST", "/v1/assets", cut, type).status, 400);
  EXPECT_EQ(send("GET", "/v1/assets/" + hex_of("{ }")).status, 404)
      << "nothing is kept of a form that broke off";
}

TEST_F(AssetRoutesTest, RequestsReferToAssets) {
  send("POST", "/v1/assets", kEmptyModel);
  const std::string id = "asset:sha256-" + hex_of(kEmptyModel);
  EXPECT_EQ(render(R"({"scene":{"model":")" + id + R"("}})").status, 200);
  const Reply missing = render(R"({"scene":{"model":"asset:sha256-)" + hex_of("?") + R"("}})");
  EXPECT_EQ(missing.status, 404);
  EXPECT_THAT(missing.body, HasSubstr("/scene/model"));
  EXPECT_EQ(render(R"({"environment":{"map":"asset:nonsense"}})").status, 422);
  EXPECT_EQ(send("GET", "/v1/assets/" + hex_of(kEmptyModel) + "/inspect").status, 200);
  EXPECT_EQ(send("GET", "/v1/assets/" + hex_of("?") + "/inspect").status, 404);
}

TEST_F(AssetRoutesTest, MetricsTellOfTheStore) {
  send("POST", "/v1/assets", "hello");
  const std::string text = send("GET", "/metrics").body;
  EXPECT_THAT(text, HasSubstr("furnace_assets 1\n"));
  EXPECT_THAT(text, HasSubstr("furnace_asset_bytes 4096\n"));
  EXPECT_THAT(text, HasSubstr("furnace_asset_uploads_total 1\n"));
}

TEST_F(NoAssetRoutesTest, WithoutAFolderUploadsAreRefusedBeforeTheirBody) {
  const Reply reply = send("POST", "/v1/assets", "hello");
  EXPECT_EQ(reply.status, 507);
  EXPECT_TRUE(was_unwanted_);
  EXPECT_THAT(reply.body, HasSubstr("--data"));
  EXPECT_EQ(send("PUT", "/v1/assets/" + hex_of("x"), "x").status, 507);
  EXPECT_EQ(send("GET", "/v1/assets/" + hex_of("x")).status, 404);
}

}  // namespace
}  // namespace furnace
