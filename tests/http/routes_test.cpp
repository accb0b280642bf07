// The whole API without a socket and without GL.
#include "server/routes.hpp"

#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/http/routes_fixture.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "api/document.hpp"

namespace furnace {
namespace {

using ::testing::HasSubstr;

constexpr const char* kSmall = R"({"output":{"width":8,"height":8}})";

using RoutesTest = testing::RoutesFixture;

TEST_F(RoutesTest, APictureWithItsHeaders) {
  const Reply reply = post(kSmall);
  EXPECT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(reply.media_type, "image/png");
  EXPECT_TRUE(reply.body.starts_with("\x89PNG"));
  EXPECT_EQ(header(reply, "ETag").front(), '"');
  EXPECT_EQ(header(reply, "Vary"), "Accept");
  EXPECT_EQ(header(reply, "Furnace-Fingerprint"), "fake/1");
  EXPECT_EQ(header(reply, "Furnace-Notes"), "0");
  EXPECT_EQ(header(reply, "Furnace-Exposure-Ev"), "0.25");
  EXPECT_EQ(header(reply, "X-Request-Id"), "test-id");
  EXPECT_EQ(header(reply, "X-Content-Type-Options"), "nosniff");
  EXPECT_THAT(header(reply, "Server-Timing"), HasSubstr("draw;dur=1.00"));
}

TEST_F(RoutesTest, AnEmptyPostIsTheDefaultPicture) {
  Request request;
  request.method = "POST";
  request.path = "/v1/renders";
  EXPECT_EQ(send(request).status, 200);
}

TEST_F(RoutesTest, AKnownTagIsAnsweredWithoutDrawing) {
  const std::string etag = header(post(kSmall), "ETag");
  EXPECT_EQ(fake_.drawn, 1);
  const Reply reply = post(kSmall, {{"If-None-Match", "\"other\", " + etag}});
  EXPECT_EQ(reply.status, 304);
  EXPECT_EQ(reply.body, "");
  EXPECT_EQ(header(reply, "ETag"), etag);
  EXPECT_EQ(fake_.drawn, 1);
  EXPECT_EQ(post(R"({"output":{"width":9,"height":8}})", {{"If-None-Match", etag}}).status, 200);
}

TEST_F(RoutesTest, AcceptChoosesAFormatThatTheDocumentLeavesOpen) {
  EXPECT_EQ(post(kSmall, {{"Accept", "image/x-exr"}}).media_type, "image/x-exr");
  EXPECT_EQ(post(kSmall, {{"Accept", "image/png;q=0.5, image/x-exr"}}).media_type, "image/x-exr");
  EXPECT_EQ(post(kSmall, {{"Accept", "*/*"}}).media_type, "image/png");
  EXPECT_EQ(post(kSmall, {{"Accept", "image/jpeg"}}).media_type, "image/jpeg");
  EXPECT_EQ(post(kSmall, {{"Accept", "image/webp, image/jpeg;q=0.9"}}).media_type, "image/webp");
  // What browsers send: nothing is liked better than PNG.
  EXPECT_EQ(post(kSmall, {{"Accept", "image/avif,image/webp,image/apng,image/*,*/*;q=0.8"}}).media_type,
            "image/png");
  expect_problem(post(R"({"environment":{"background":{"type":"transparent"}}})", {{"Accept", "image/jpeg"}}),
                 422);
  EXPECT_NE(header(post(kSmall, {{"Accept", "image/x-exr"}}), "ETag"), header(post(kSmall), "ETag"));
}

TEST_F(RoutesTest, AFormatInTheDocumentWinsUnlessAcceptExcludesIt) {
  const std::string exr = R"({"output":{"width":8,"height":8,"format":"exr"}})";
  EXPECT_EQ(post(exr, {{"Accept", "image/png, */*;q=0.1"}}).media_type, "image/x-exr");
  expect_problem(post(exr, {{"Accept", "image/png"}}), 406);
  expect_problem(post(kSmall, {{"Accept", "text/html"}}), 406);
  expect_problem(post(R"({"output":{"format":"png"}})", {{"Accept", "image/x-exr"}}), 406);
}

TEST_F(RoutesTest, ASequenceIsOfItsContainersType) {
  const std::string turn =
      R"({"output":{"width":8,"height":8,"sequence":{"frames":2,"turntableDegrees":90}}})";
  EXPECT_EQ(post(turn).media_type, "image/apng");
  EXPECT_EQ(post(turn, {{"Accept", "image/png"}}).media_type, "image/apng") << "which is a PNG";
  EXPECT_EQ(post(turn, {{"Accept", "image/apng"}}).media_type, "image/apng");
  EXPECT_EQ(post(turn, {{"Accept", "image/webp"}}).media_type, "image/webp");
  expect_problem(post(turn, {{"Accept", "image/jpeg"}}), 422);
  const std::string files =
      R"({"output":{"width":8,"height":8,"sequence":{"frames":2,"turntableDegrees":90,"container":"zip"}}})";
  EXPECT_EQ(post(files, {{"Accept", "application/zip"}}).media_type, "application/zip");
  expect_problem(post(files, {{"Accept", "image/png"}}), 406);
}

TEST_F(RoutesTest, BrokenRequestsAreProblems) {
  expect_problem(post("{"), 400);
  expect_problem(post(R"({"output":{"width":0,"colour":1}})"), 422);
  expect_problem(post(kSmall, {{"Content-Type", "text/plain"}}), 415);
  expect_problem(post("no boundary", {{"Content-Type", "multipart/form-data"}}), 400);
}

TEST_F(RoutesTest, AllProblemsWithTheirPointers) {
  const Reply reply = post(R"({"output":{"width":0,"colour":1}})");
  EXPECT_THAT(reply.body, HasSubstr("/output/width"));
  EXPECT_THAT(reply.body, HasSubstr("/output/colour"));
}

TEST_F(RoutesTest, FilesOfAMultipartRequest) {
  const std::map<std::string, std::string, HeaderLess> type = {
      {"Content-Type", "multipart/form-data; boundary=B"}};
  const auto part = [](const std::string& name, const std::string& body) {
    return "--B\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + body + "\r\n";
  };
  EXPECT_EQ(post(part("request", kSmall) + "--B--", type).status, 200);
  EXPECT_EQ(post(part("unused", "bytes") + "--B--", type).status, 200);
  expect_problem(post(part("request", "{}") + part("request", "{}") + "--B--", type), 400);
  expect_problem(
      post(part("a", "") + part("b", "") + part("c", "") + part("d", "") + part("e", "") + "--B--", type),
      413);
  expect_problem(post(part("request", R"({"scene":{"model":"part:absent"}})") + "--B--", type), 404);
}

TEST_F(RoutesTest, NotesAreCounted) {
  fake_.notes = {{"a", "", ""}, {"b", "", ""}, {"a", "", ""}};
  EXPECT_EQ(header(post(kSmall), "Furnace-Notes"), "3;codes=\"a b\"");
}

TEST_F(RoutesTest, APictureLinksToItsReport) {
  fake_.notes = {{"image-missing", "/images/1", "the file b.png is missing"}};
  const Reply picture = post(kSmall);
  const std::string tag = header(picture, "ETag").substr(1, 64), path = "/v1/reports/" + tag;
  EXPECT_EQ(header(picture, "Link"), "<" + path + ">; rel=\"describedby\"; type=\"application/json\"");
  const Reply reply = get(path);
  ASSERT_EQ(reply.status, 200) << reply.body;
  const api::Document document = api::Document::parse(reply.body, {});
  const api::Value report = document.root();
  EXPECT_EQ(report["etag"].text(), tag);
  EXPECT_EQ(report["fingerprint"].text(), "fake/1");
  EXPECT_EQ(report["mediaType"].text(), "image/png");
  EXPECT_EQ(report["width"].integer(), 8);
  EXPECT_EQ(report["bytes"].integer(), int(picture.body.size()));
  EXPECT_EQ(report["exposureEv"].number(), 0.25);
  ASSERT_EQ(report["stages"].size(), 7u);
  EXPECT_EQ(report["stages"].at(4)["name"].text(), "draw");
  ASSERT_EQ(report["notes"].size(), 1u);
  EXPECT_EQ(report["notes"].at(0)["code"].text(), "image-missing");
  EXPECT_EQ(report["notes"].at(0)["pointer"].text(), "/images/1");
  EXPECT_EQ(header(post(kSmall, {{"If-None-Match", header(picture, "ETag")}}), "Link"),
            header(picture, "Link"));
  expect_problem(get("/v1/reports/" + std::string(64, '0')), 404);
  expect_problem(get("/v1/reports/"), 404);
}

TEST_F(RoutesTest, EqualRequestsAreDrawnOnceAndStandUnderTheirTag) {
  const Reply drawn = post(kSmall), again = post(kSmall);
  EXPECT_EQ(fake_.drawn, 1);
  EXPECT_EQ(header(drawn, "Cache-Status"), "furnace; fwd=miss; stored");
  EXPECT_EQ(header(again, "Cache-Status"), "furnace; hit; detail=memory");
  EXPECT_EQ(header(again, "Server-Timing"), "(none)");
  EXPECT_EQ(again.body, drawn.body);
  const std::string path = header(drawn, "Content-Location"), etag = header(drawn, "ETag");
  EXPECT_EQ(path, "/v1/renders/" + etag.substr(1, 64));
  const Reply kept = get(path);
  EXPECT_EQ(kept.status, 200);
  EXPECT_EQ(kept.media_type, "image/png");
  EXPECT_EQ(kept.body, drawn.body);
  EXPECT_EQ(header(kept, "ETag"), etag);
  EXPECT_EQ(header(kept, "Cache-Control"), "public, max-age=31536000, immutable");
  expect_problem(get("/v1/renders/" + std::string(64, '0')), 404);
  expect_problem(get("/v1/renders/" + std::string(63, '0') + "G"), 404);
  expect_problem(get("/v1/renders/"), 404);
}

// A triangle without normals, its buffer in the document.
constexpr const char* kTriangle =
    R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

TEST_F(RoutesTest, WhatIsInAModel) {
  const auto inspect = [&](std::string body, std::string type) {
    Request request;
    request.method = "POST";
    request.path = "/v1/inspect";
    request.headers["Content-Type"] = std::move(type);
    request.body = std::move(body);
    return send(request);
  };
  const auto multipart = [&](const std::string& document) {
    const std::string head = "--B\r\nContent-Disposition: form-data; name=\"";
    return inspect(
        head + "request\"\r\n\r\n" + document + "\r\n" + head + "t.gltf\"\r\n\r\n" + kTriangle + "\r\n--B--",
        "multipart/form-data; boundary=B");
  };
  for (const Reply& reply :
       {inspect(kTriangle, "model/gltf+json"), multipart(R"({"model":"part:t.gltf","gltfScene":-1})"),
        multipart(R"({"model":"part:t.gltf"})")}) {
    if (reply.status != 200) {
      EXPECT_THAT(reply.body, HasSubstr("/gltfScene"));
      continue;
    }
    const api::Document document = api::Document::parse(reply.body, {});
    const api::Value report = document.root();
    EXPECT_EQ(report["drawn"]["triangles"].integer(), 1);
    EXPECT_EQ(report["drawn"]["bounds"]["max"].at(1).number(), 1);
    EXPECT_EQ(report["notes"].at(0)["code"].text(), "normals-generated");
  }
  expect_problem(multipart(R"({"model":"part:t.gltf","gltfScene":-1})"), 422);
  const Reply no_variant = multipart(R"({"model":"part:t.gltf","variant":"night"})");
  expect_problem(no_variant, 422);
  EXPECT_EQ(api::Document::parse(no_variant.body, {}).root()["pointer"].text(), "/model");
  expect_problem(multipart(R"({"model":"part:other.gltf"})"), 404);
  expect_problem(multipart("{}"), 422);
  expect_problem(inspect("{", "application/json"), 400);
  expect_problem(inspect("glTF", "model/gltf-binary"), 422);
  expect_problem(inspect(kTriangle, "text/plain"), 415);
  const auto seat = admission_.enter({});
  expect_problem(inspect(kTriangle, "model/gltf+json"), 429);
}

// Whatever the importer notes is an error under "strict": the codes are read from its sources.
TEST_F(RoutesTest, StrictRefusesEveryNoteOfTheImporter) {
  const std::filesystem::path folder = std::filesystem::path(FURNACE_SOURCE_DIR) / "renderer/scene";
  const std::regex call(R"(notes_?\.add\(\s*\"([a-z0-9-]+)\")");
  std::set<std::string> codes;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::stringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    const std::string source = text.str();
    for (std::sregex_iterator match(source.begin(), source.end(), call), end; match != end; ++match)
      codes.insert((*match)[1]);
  }
  EXPECT_GE(codes.size(), 12u);
  for (const std::string& code : codes) {
    fake_.notes = {{code, "/a/b", "what happened"}};
    const Reply reply = post(R"({"strict":true,"output":{"width":8,"height":8}})");
    expect_problem(reply, 422);
    EXPECT_THAT(reply.body, HasSubstr(code + ": what happened"));
    EXPECT_THAT(reply.body, HasSubstr("/a/b"));
  }
}

TEST_F(RoutesTest, StrangersAndWrongMethods) {
  expect_problem(get("/v1/nothing"), 404);
  const Reply reply = get("/v1/renders");
  expect_problem(reply, 405);
  EXPECT_EQ(header(reply, "Allow"), "POST, OPTIONS");
  Request request;
  request.method = "OPTIONS";
  request.path = "/version";
  EXPECT_EQ(header(send(request), "Allow"), "GET, HEAD, OPTIONS");
}

TEST_F(RoutesTest, OverloadSaysWhenToComeBack) {
  const auto seat = admission_.enter({});
  const Reply reply = post(kSmall);
  expect_problem(reply, 429);
  EXPECT_EQ(header(reply, "Retry-After"), "1");
}

TEST_F(RoutesTest, WhateverAHandlerThrowsIsAProblem) {
  fake_.before_drawing = [](const Deadline&) { throw std::runtime_error("secret of the house"); };
  const Reply reply = post(kSmall);
  expect_problem(reply, 500);
  EXPECT_EQ(reply.body.find("secret"), std::string::npos);
}

TEST_F(RoutesTest, APassedDeadlineIs504) {
  Request request;
  request.method = "POST";
  request.path = "/v1/renders";
  request.deadline = Deadline(std::chrono::milliseconds(-1));
  expect_problem(send(request), 504);
}

TEST_F(RoutesTest, Documents) {
  for (const char* path : {"/v1/schema.json", "/openapi.json", "/v1/capabilities", "/version"}) {
    const Reply reply = get(path);
    EXPECT_EQ(reply.status, 200) << path;
    EXPECT_NO_THROW(api::Document::parse(reply.body, {})) << path;
    Request again;
    again.method = "HEAD";
    again.path = path;
    again.headers["If-None-Match"] = header(reply, "ETag");
    EXPECT_EQ(send(again).status, 304) << path;
  }
  EXPECT_EQ(get("/").status, 200);
}

TEST_F(RoutesTest, Health) {
  EXPECT_EQ(get("/livez").status, 200);
  probe_is_right_ = false;
  expect_problem(get("/readyz"), 503);
  probe_is_right_ = true;
  EXPECT_EQ(get("/readyz").status, 200);
  readiness_.drain();
  expect_problem(get("/readyz"), 503);
  EXPECT_EQ(get("/livez").status, 200);
}

TEST_F(RoutesTest, NobodyWaitsForAnothersProbe) {
  Readiness* asked_meanwhile = nullptr;
  int meanwhile = 0;
  Readiness readiness(
      [&](const Deadline&) {
        if (asked_meanwhile) {
          // The mutex is this thread's: another one has to ask.
          std::jthread([&] {
            try {
              asked_meanwhile->check();
              meanwhile = 200;
            } catch (const Error&) {
              meanwhile = 503;
            }
          }).join();
        }
        return true;
      },
      std::chrono::seconds(1));
  asked_meanwhile = &readiness;
  readiness.check();
  EXPECT_EQ(meanwhile, 503) << "before the first answer there is none to give";
}

TEST_F(RoutesTest, MetricsCountWhatHappened) {
  post(kSmall);
  get("/v1/nothing");
  const std::string text = get("/metrics").body;
  EXPECT_THAT(text, HasSubstr("furnace_requests_total{route=\"/v1/renders\",status=\"200\"} 1"));
  EXPECT_THAT(text, HasSubstr("furnace_requests_total{route=\"none\",status=\"404\"} 1"));
  EXPECT_THAT(text, HasSubstr("furnace_renders_total 1"));
  EXPECT_THAT(text, HasSubstr("furnace_request_span_duration_seconds_count{span=\"draw\"} 1"));
}

TEST_F(RoutesTest, OperationsCanLeaveMetricsToTheOtherListener) {
  const Dispatcher without(public_routes(doors_, false), metrics_);
  Request request;
  request.method = "GET";
  request.path = "/metrics";
  EXPECT_EQ(without.handle(request).status, 404);
  EXPECT_EQ(Dispatcher(operation_routes(doors_, true), metrics_).handle(request).status, 200);
}

}  // namespace
}  // namespace furnace
