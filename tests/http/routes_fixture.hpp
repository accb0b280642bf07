// All routes over a painter without GL.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "tests/http/fake_painter.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "api/document.hpp"
#include "server/routes.hpp"

namespace furnace::testing {

// Threads: one. Owns: what a server has, but a socket.
class RoutesFixture : public ::testing::Test {
 protected:
  Reply send(Request request) const { return dispatcher_.handle(request); }

  Reply get(std::string path) const {
    Request request;
    request.method = "GET";
    request.path = std::move(path);
    return send(request);
  }

  Reply post(std::string body, std::map<std::string, std::string, HeaderLess> headers = {}) const {
    Request request;
    request.method = "POST";
    request.path = "/v1/renders";
    request.id = "test-id";
    request.headers = std::move(headers);
    request.headers.emplace("Content-Type", "application/json");
    request.body = std::move(body);
    return send(request);
  }

  static std::string header(const Reply& reply, std::string_view name) {
    for (const auto& [key, value] : reply.headers) {
      if (key == name) return value;
    }
    return "(none)";
  }

  // A problem document of this status, with the status inside it.
  static void expect_problem(const Reply& reply, int status) {
    EXPECT_EQ(reply.status, status) << reply.body;
    EXPECT_EQ(reply.media_type, "application/problem+json");
    EXPECT_EQ(header(reply, "Cache-Control"), "no-store");
    const auto document = api::Document::parse(reply.body, {});
    EXPECT_EQ(document.root()["status"].integer(), status);
    EXPECT_FALSE(document.root()["title"].text().empty());
  }

  FakePainter fake_;
  WorkerPool pool_{1};
  Admission admission_{1, 0};
  RenderCache renders_{{1 << 20, {}, 0}};
  RenderService service_{fake_.painter(), admission_, pool_, renders_};
  FileAssets files_{{}, 0, 1 << 20};
  Metrics metrics_{"test"};
  bool probe_is_right_ = true;
  Readiness readiness_{[this](const Deadline&) { return probe_is_right_; }, std::chrono::seconds(1)};
  EnvironmentRegistry environments_{
      [](const EnvironmentSpec&, const Deadline&) { return EnvironmentAnswer{}; },
      admission_,
      pool_,
      decode::in_process_decoder(),
      {}};
  const Doors doors_{service_, admission_, files_, decode::in_process_decoder(), environments_, readiness_,
                     metrics_, {},         4};
  const Dispatcher dispatcher_{public_routes(doors_, true), metrics_};
};

}  // namespace furnace::testing
