#include "server/gate.hpp"

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/http/routes_fixture.hpp"
#include "renderer/base/error.hpp"
#include "server/api_keys.hpp"
#include "server/rate_limit.hpp"
#include "server/url_query.hpp"
#include "server/url_signature.hpp"

namespace furnace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string hash_of(const std::string& key) {
  return hash_bytes(std::as_bytes(std::span(key))).hex();
}

TEST(ApiKeys, WhatALineSays) {
  const auto keys = parse_api_keys("# ours\nshop:render:" + hash_of("a") +
                                   "\n\nci.1:render,assets,admin:" + hash_of("b") + ":60:1000:2GiB\r\n");
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].name, "shop");
  EXPECT_EQ(keys[0].scopes, scope::kRender);
  EXPECT_EQ(keys[0].rate_per_minute, 0);
  EXPECT_EQ(keys[1].scopes, scope::kRender | scope::kAssets | scope::kAdmin);
  EXPECT_EQ(keys[1].hash.hex(), hash_of("b"));
  EXPECT_EQ(keys[1].rate_per_minute, 60);
  EXPECT_EQ(keys[1].renders_per_day, 1000);
  EXPECT_EQ(keys[0].asset_bytes, 0);
  EXPECT_EQ(keys[1].asset_bytes, 2ll << 30);
}

TEST(ApiKeys, AllProblems) {
  const std::string a = hash_of("a"), b = hash_of("b");
  const std::string text = "a:render:" + a + "\na:render:" + b + "\nb:render:" + a + "\nc:draw:" + b +
                           "\nd::" + b + "\ne:render,:" + b + "\nf:render:" + b.substr(1) +
                           "\ng:render:" + b + ":x\nh:render:" + b + ":1:-1\ni:render\nj:render:" + b +
                           ":1:2:3GB\n:render:" + b + "\nk:render:" + b + ":\n";
  try {
    parse_api_keys(text);
    FAIL() << "it was taken";
  } catch (const Error& error) {
    std::vector<std::string> places;
    for (const Problem& problem : error.problems) places.push_back(problem.pointer);
    EXPECT_THAT(places, ElementsAre("line 2", "line 3", "line 4", "line 5", "line 6", "line 7", "line 8",
                                    "line 9", "line 10", "line 11", "line 12", "line 13"));
  }
  EXPECT_THROW(parse_api_keys("\n# none\n"), Error);
}

TEST(ApiKeys, Garbage) {
  const std::string line = "name:render,admin:" + hash_of("a") + ":60:1000:1MiB\n";
  std::mt19937 random(6);
  for (int i = 0; i < 5000; ++i) {
    std::string text = line;
    for (auto changes = random() % 4; changes > 0; --changes)
      text[random() % text.size()] = static_cast<char>(random());
    text.resize(random() % (text.size() + 1));
    try {
      parse_api_keys(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    }
  }
}

TEST(TokenBucket, AMinutesWorthThenTheRate) {
  Clock::time_point now{};
  TokenBucket bucket(6, now);
  for (int i = 5; i >= 0; --i) EXPECT_EQ(bucket.take(now).left, i);
  const Allowance none = bucket.take(now);
  EXPECT_FALSE(none.granted);
  EXPECT_EQ(none.retry_s, 10);
  EXPECT_EQ(none.reset_s, 60);
  EXPECT_FALSE(bucket.take(now += std::chrono::milliseconds(9900)).granted);
  EXPECT_TRUE(bucket.take(now += std::chrono::milliseconds(100)).granted);
  EXPECT_FALSE(bucket.take(now).granted);
  EXPECT_EQ(bucket.take(now += std::chrono::hours(5)).left, 5) << "it does not fill beyond its size";
  EXPECT_EQ(bucket.take(now - std::chrono::hours(1)).left, 4) << "a clock never takes back";
}

TEST(DayQuota, FromMidnightToMidnight) {
  constexpr std::int64_t kMidnight = 20'000 * 86'400ll;
  DayQuota quota(2);
  EXPECT_EQ(quota.take(kMidnight).left, 1);
  EXPECT_TRUE(quota.take(kMidnight + 10).granted);
  const Allowance none = quota.take(kMidnight + 86'000);
  EXPECT_FALSE(none.granted);
  EXPECT_EQ(none.retry_s, 400);
  quota.correct(-1);
  EXPECT_TRUE(quota.take(kMidnight + 86'399).granted);
  EXPECT_FALSE(quota.take(kMidnight + 86'399).granted);
  EXPECT_EQ(quota.take(kMidnight + 86'400).left, 1);
}

constexpr std::int64_t kNow = 1'800'000'000;
const UrlKey kUrlKey{"k1", std::string(32, 's')};

// The routes behind a gate with keys: "all", "draw" (6 a minute, 2 renders a day) and "put".
class GateTest : public testing::RoutesFixture {
 protected:
  GateTest() {
    write("api", "all:render,assets,admin:" + hash_of("key-all") + "\ndraw:render:" + hash_of("key-draw") +
                     ":6:2\nput:assets:" + hash_of("key-put") + "\n");
  }
  ~GateTest() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  GateClock clock() {
    return {[this] { return now_; }, [this] { return unix_s_; }};
  }
  Dispatcher behind(Gate& gate) { return Dispatcher(public_routes(doors_, true), metrics_, &gate); }

  static Request ask(std::string method, std::string path, std::string key = {}, std::string query = {}) {
    Request request;
    request.method = std::move(method);
    request.path = std::move(path);
    request.query = std::move(query);
    if (!key.empty()) request.headers["Authorization"] = "Bearer " + key;
    return request;
  }

  Clock::time_point now_{};
  std::int64_t unix_s_ = kNow;
  const std::filesystem::path folder_ = [] {
    const auto folder =
        std::filesystem::path(::testing::TempDir()) /
        (std::string("gate_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder);
    return folder;
  }();
};

// Whoever adds a route says who may use it: without a key only these.
TEST_F(GateTest, WithoutAKeyOnlyHealthAndDocuments) {
  Gate gate({path("api"), {}, {}}, clock());
  const Dispatcher dispatcher = behind(gate);
  const std::set<std::string_view> open = {"/livez",        "/readyz",          "/version", "/v1/schema.json",
                                           "/openapi.json", "/v1/capabilities", "/"};
  int closed = 0;
  for (const Route& route : public_routes(doors_, true)) {
    SCOPED_TRACE(std::string(route.method) + " " + std::string(route.path));
    const Reply reply = dispatcher.handle(ask(std::string(route.method), std::string(route.path)));
    if (open.contains(route.path)) {
      EXPECT_EQ(reply.status, 200);
      continue;
    }
    ++closed;
    expect_problem(reply, 401);
    EXPECT_THAT(header(reply, "WWW-Authenticate"), HasSubstr("Bearer"));
    expect_problem(dispatcher.handle(ask(std::string(route.method), std::string(route.path), "key-al")), 401);
  }
  EXPECT_GE(closed, 9);
  EXPECT_EQ(fake_.drawn, 0);
}

TEST_F(GateTest, ScopesOpenTheirRoutes) {
  Gate gate({path("api"), {}, {}}, clock());
  const Dispatcher dispatcher = behind(gate);
  EXPECT_EQ(dispatcher.handle(ask("POST", "/v1/renders", "key-draw")).status, 200);
  EXPECT_EQ(dispatcher.handle(ask("GET", "/v1/render", "key-draw")).status, 200);
  expect_problem(dispatcher.handle(ask("POST", "/v1/renders", "key-put")), 403);
  expect_problem(dispatcher.handle(ask("GET", "/v1/render", "key-put")), 403);
  expect_problem(dispatcher.handle(ask("DELETE", "/v1/environments/none", "key-draw")), 403);
  expect_problem(dispatcher.handle(ask("DELETE", "/v1/environments/none", "key-put")), 404);
  expect_problem(dispatcher.handle(ask("GET", "/metrics", "key-put")), 403);
  EXPECT_EQ(dispatcher.handle(ask("GET", "/metrics", "key-all")).status, 200);
  EXPECT_EQ(header(dispatcher.handle(ask("GET", "/v1/render", "key-all")), "Cache-Control").substr(0, 7),
            "private");

  Request request = ask("POST", "/v1/renders");
  request.headers["x-api-key"] = "key-all";
  EXPECT_EQ(dispatcher.handle(request).status, 200);
  request.headers["Authorization"] = "bEARER key-all";
  EXPECT_EQ(dispatcher.handle(request).status, 200);
  request.headers["Authorization"] = "Bearer key-all, Bearer key-all";
  EXPECT_EQ(dispatcher.handle(request).status, 401);
  EXPECT_THAT(metrics_.text(), HasSubstr("furnace_client_requests_total{client=\"put\",status=\"403\"} 3"));
  EXPECT_EQ(metrics_.text().find("key-"), std::string::npos);
}

TEST_F(GateTest, ABatchIsSoManyRenders) {
  Gate gate({path("api"), {}, {}}, clock());
  const Dispatcher dispatcher = behind(gate);
  Request batch = ask("POST", "/v1/batches", "key-draw");
  batch.headers["Content-Type"] = "application/json";
  batch.body = R"({"items":[{"name":"a"},{"name":"b"},{"name":"c"}]})";
  const Reply drawn = dispatcher.handle(batch);
  EXPECT_EQ(drawn.status, 200) << drawn.body;
  expect_problem(dispatcher.handle(ask("POST", "/v1/renders", "key-draw")), 429);
  unix_s_ += 86'400;
  EXPECT_EQ(dispatcher.handle(ask("POST", "/v1/renders", "key-draw")).status, 200);
}

TEST_F(GateTest, RateAndQuota) {
  Gate gate({path("api"), {}, {}}, clock());
  const Dispatcher dispatcher = behind(gate);
  const Request render = ask("POST", "/v1/renders", "key-draw"), list = ask("GET", "/v1/presets", "key-draw");
  const Reply first = dispatcher.handle(render);
  EXPECT_EQ(header(first, "RateLimit-Policy"), "\"requests\";q=6;w=60, \"renders\";q=2;w=86400");
  EXPECT_THAT(header(first, "RateLimit"), HasSubstr("\"requests\";r=5;t=10, \"renders\";r=1;t="));
  Request wrong = render;
  wrong.headers["Content-Type"] = "text/plain";
  wrong.body = "x";
  expect_problem(dispatcher.handle(wrong), 415);
  EXPECT_EQ(dispatcher.handle(render).status, 200) << "what failed was no render of the day";
  const Reply spent = dispatcher.handle(render);
  expect_problem(spent, 429);
  EXPECT_EQ(header(spent, "Retry-After"), std::to_string(86'400 - kNow % 86'400));
  EXPECT_EQ(dispatcher.handle(list).status, 200);
  EXPECT_EQ(dispatcher.handle(list).status, 200);
  const Reply fast = dispatcher.handle(list);
  expect_problem(fast, 429);
  EXPECT_EQ(header(fast, "Retry-After"), "10");
  now_ += std::chrono::seconds(10);
  EXPECT_EQ(dispatcher.handle(list).status, 200);
  EXPECT_EQ(dispatcher.handle(list).status, 429);
  now_ += std::chrono::seconds(60);
  unix_s_ += 86'400;
  EXPECT_EQ(dispatcher.handle(render).status, 200);
  EXPECT_EQ(header(dispatcher.handle(ask("GET", "/v1/presets", "key-all")), "RateLimit"), "(none)");
}

TEST_F(GateTest, ReloadedKeysCountAtOnce) {
  Gate gate({path("api"), {}, {}}, clock());
  const Dispatcher dispatcher = behind(gate);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(dispatcher.handle(ask("GET", "/v1/presets", "key-draw")).status, 200);
  write("api", "draw:render:" + hash_of("key-new") + ":6:2\n");
  gate.reload();
  expect_problem(dispatcher.handle(ask("GET", "/v1/presets", "key-all")), 401);
  expect_problem(dispatcher.handle(ask("GET", "/v1/presets", "key-draw")), 401);
  expect_problem(dispatcher.handle(ask("GET", "/v1/presets", "key-new")), 429);
  write("api", "nonsense");
  EXPECT_THROW(gate.reload(), Error);
  expect_problem(dispatcher.handle(ask("GET", "/v1/presets", "key-new")), 429);
}

TEST_F(GateTest, SignedUrlsNeedNoKey) {
  write("url", kUrlKey.id + ":" + std::string(64, '7') + "\n");
  std::filesystem::permissions(path("url"), std::filesystem::perms::owner_read);
  const UrlKey key{kUrlKey.id, std::string(32, '\x77')};
  Gate gate({path("api"), path("url"), {}}, clock());
  const Dispatcher dispatcher = behind(gate);
  const auto image = [&](const std::string& url, std::string bearer = {}) {
    return dispatcher.handle(ask("GET", "/v1/render", std::move(bearer), url.substr(url.find('?') + 1)));
  };
  const std::string url = signed_url({{"width", "8"}, {"height", "8"}}, key, kNow + 60);
  EXPECT_EQ(image(url).status, 200);
  EXPECT_EQ(header(image(url), "Cache-Control").substr(0, 6), "public");
  expect_problem(image("?width=8&height=8"), 403);
  expect_problem(image("?width=8&height=8", "key-all"), 403);
  expect_problem(image(url + "&quality=high"), 403);
  expect_problem(image(signed_url({{"width", "8"}}, kUrlKey, kNow + 60)), 403);
  expect_problem(image("?width=%&nonsense=1&width=1"), 403);
  EXPECT_EQ(fake_.drawn, 1);
  expect_problem(image(signed_url({{"width", "0"}}, key, kNow + 60)), 422);
  unix_s_ += 60;
  expect_problem(image(url), 403);
}

TEST_F(GateTest, SecretsThatEveryoneCanReadAreRefused) {
  write("url", kUrlKey.id + ":" + std::string(64, '7') + "\n");
  std::filesystem::permissions(path("url"), std::filesystem::perms(0644));
  EXPECT_THROW(Gate({{}, path("url"), {}}), Error);
  std::filesystem::permissions(path("url"), std::filesystem::perms(0640));
  EXPECT_NO_THROW(Gate({{}, path("url"), {}}));
  EXPECT_THROW(Gate({path("absent"), {}, {}}), Error);
}

TEST_F(GateTest, LongUrls) {
  Gate gate({{}, {}, {}, 64});
  const Dispatcher dispatcher = behind(gate);
  expect_problem(dispatcher.handle(ask("GET", "/v1/render", {}, "model=" + std::string(64, 'x'))), 414);
  EXPECT_EQ(dispatcher.handle(ask("GET", "/v1/render", {}, "width=8&height=8")).status, 200);
}

TEST_F(GateTest, Cors) {
  Gate none({}), one({{}, {}, "https://example.com, http://localhost:3000"}), all({{}, {}, "*"});
  const auto reply_of = [&](Gate& gate, std::string method, std::string origin,
                            std::string path = "/version") {
    Request request = ask(std::move(method), std::move(path));
    if (!origin.empty()) request.headers["Origin"] = std::move(origin);
    request.headers["Access-Control-Request-Method"] = "POST";
    return behind(gate).handle(request);
  };
  constexpr const char* kOrigin = "Access-Control-Allow-Origin";
  EXPECT_EQ(header(reply_of(none, "GET", "https://example.com"), kOrigin), "(none)");
  EXPECT_EQ(header(reply_of(none, "GET", "https://example.com"), "Vary"), "(none)");
  EXPECT_EQ(header(reply_of(all, "GET", "https://example.org"), kOrigin), "*");
  EXPECT_EQ(header(reply_of(one, "GET", "https://example.com"), kOrigin), "https://example.com");
  EXPECT_EQ(header(reply_of(one, "GET", "https://example.com", "/nothing"), kOrigin), "https://example.com");
  EXPECT_EQ(header(reply_of(one, "GET", "https://example.org"), kOrigin), "(none)");
  EXPECT_EQ(header(reply_of(one, "GET", ""), "Vary"), "Origin") << "a cache must keep them apart";
  const Reply preflight = reply_of(one, "OPTIONS", "http://localhost:3000", "/v1/renders");
  EXPECT_EQ(preflight.status, 204);
  EXPECT_EQ(header(preflight, kOrigin), "http://localhost:3000");
  EXPECT_EQ(header(preflight, "Access-Control-Allow-Methods"), "POST, OPTIONS");
  EXPECT_THAT(header(preflight, "Access-Control-Allow-Headers"), HasSubstr("Authorization"));
  EXPECT_EQ(header(reply_of(one, "OPTIONS", "https://example.org"), "Access-Control-Allow-Methods"),
            "(none)");
  for (const char* wrong : {"example.com", "https://example.com/", "https://Localhost", "https://", "ftp://a",
                            "https://a b", "https://a,", "null"})
    EXPECT_EQ(Cors::fault(wrong).empty(), std::string_view(wrong) == "https://a,") << wrong;
}

}  // namespace
}  // namespace furnace
