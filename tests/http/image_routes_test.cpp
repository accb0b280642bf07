// GET /v1/render through the route table.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/http/routes_fixture.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

using ::testing::HasSubstr;

class ImageRoutesTest : public testing::RoutesFixture {
 protected:
  Reply image(std::string query, std::map<std::string, std::string, HeaderLess> headers = {},
              std::string method = "GET") const {
    Request request;
    request.method = std::move(method);
    request.path = "/v1/render";
    request.query = std::move(query);
    request.headers = std::move(headers);
    return send(request);
  }
};

TEST_F(ImageRoutesTest, TheSamePictureAsByPost) {
  const std::string document = R"({"output":{"width":8,"height":6},"scene":{"model":"builtin:torus"}})";
  const Reply posted = post(document);
  ASSERT_EQ(posted.status, 200) << posted.body;
  for (const std::string& query :
       {std::string("width=8&height=6&model=builtin:torus"),
        std::string("height=6&model=builtin%3Atorus&width=8.0"), "r=" + base64url(document),
        "height=6&r=" + base64url(R"({"output":{"width":8},"scene":{"model":"builtin:torus"}})")}) {
    const Reply reply = image(query);
    ASSERT_EQ(reply.status, 200) << query << reply.body;
    EXPECT_EQ(reply.body, posted.body) << query;
    EXPECT_EQ(header(reply, "ETag"), header(posted, "ETag")) << query;
    EXPECT_EQ(header(reply, "Content-Location"), header(posted, "Content-Location")) << query;
  }
  EXPECT_EQ(fake_.drawn, 1);
  EXPECT_EQ(image("width=8&height=6&model=builtin:torus", {}, "HEAD").status, 200);
}

TEST_F(ImageRoutesTest, WhatCachesAndPagesNeed) {
  const Reply reply = image("width=8&height=8");
  EXPECT_EQ(header(reply, "Cache-Control"), "public, max-age=3600, stale-while-revalidate=3600");
  EXPECT_EQ(header(reply, "Cross-Origin-Resource-Policy"), "cross-origin");
  EXPECT_EQ(std::ranges::count(reply.headers, "Cross-Origin-Resource-Policy",
                               &std::pair<std::string, std::string>::first),
            1);
  EXPECT_EQ(header(reply, "Content-Disposition"), "inline; filename=\"render.png\"");
  EXPECT_EQ(header(reply, "Vary"), "Accept");
  EXPECT_EQ(header(post(R"({"output":{"width":8,"height":8}})"), "Cross-Origin-Resource-Policy"),
            "same-site");
  EXPECT_EQ(header(post(R"({"output":{"width":8,"height":8}})"), "Cache-Control"), "no-cache");

  const Reply unchanged = image("width=8&height=8", {{"If-None-Match", header(reply, "ETag")}});
  EXPECT_EQ(unchanged.status, 304);
  EXPECT_EQ(unchanged.body, "");
  EXPECT_EQ(header(unchanged, "Cache-Control"), header(reply, "Cache-Control"));
  EXPECT_EQ(header(unchanged, "ETag"), header(reply, "ETag"));
}

TEST_F(ImageRoutesTest, AStatedFormatDoesNotDependOnAccept) {
  for (const char* accept : {"", "image/png", "text/html"}) {
    const Reply reply = image("width=8&height=8&format=jpeg", {{"Accept", accept}});
    ASSERT_EQ(reply.status, 200) << accept << reply.body;
    EXPECT_EQ(reply.media_type, "image/jpeg");
    EXPECT_EQ(header(reply, "Vary"), "(none)");
    EXPECT_EQ(header(reply, "Content-Disposition"), "inline; filename=\"render.jpeg\"");
  }
  const Reply chosen = image("width=8&height=8", {{"Accept", "image/webp"}});
  EXPECT_EQ(chosen.media_type, "image/webp");
  EXPECT_EQ(header(chosen, "Vary"), "Accept");
  expect_problem(image("width=8&height=8", {{"Accept", "text/html"}}), 406);
  EXPECT_EQ(header(image("width=8&height=8&frames=2&turntable=90"), "Content-Disposition"),
            "inline; filename=\"render.png\"");
}

TEST_F(ImageRoutesTest, ProblemsPointAtKeys) {
  const Reply reply = image("width=0&height=8&quality=best");
  expect_problem(reply, 422);
  const api::Document document = api::Document::parse(reply.body, {});
  ASSERT_EQ(document.root()["errors"].size(), 2u);
  EXPECT_EQ(document.root()["errors"].at(0)["pointer"].text(), "?quality");
  EXPECT_EQ(document.root()["errors"].at(1)["pointer"].text(), "?width");
  EXPECT_EQ(document.root()["detail"].text().find("/output"), std::string_view::npos) << reply.body;
  EXPECT_EQ(header(reply, "Cache-Control"), "no-store");

  EXPECT_THAT(image("model=part:a.glb").body, HasSubstr("?model"));
  expect_problem(image("model=part:a.glb"), 404);
  expect_problem(image("width=1&width=2"), 400);
  expect_problem(image("preset=none"), 404);
  const Reply below = image("width=8&r=" + base64url(R"({"camera":{"fovYDegrees":0}})"));
  expect_problem(below, 422);
  EXPECT_THAT(below.body, HasSubstr("\"/camera/fovYDegrees\""));
}

TEST_F(ImageRoutesTest, NoPresetsAreListedWhereThereAreNone) {
  const Reply reply = get("/v1/presets");
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(api::Document::parse(reply.body, {}).root()["presets"].size(), 0u);
}

}  // namespace
}  // namespace furnace
