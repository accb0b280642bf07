// The server's manners on a real loopback socket, with routes that draw nothing.
#include "server/http_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "server/metrics.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::StartsWith;

int connect_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return socket;
  ::close(socket);
  return -1;
}

bool can_connect(int port) {
  const int socket = connect_to(port);
  if (socket >= 0) ::close(socket);
  return socket >= 0;
}

// A client that says exactly the bytes it is given.
class Client {
 public:
  explicit Client(int port) : socket_(connect_to(port)) { EXPECT_GE(socket_, 0); }
  ~Client() { hang_up(); }
  void hang_up() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }
  void say_no_more() { ::shutdown(socket_, SHUT_WR); }
  void say(std::string_view text) { ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }
  // All that comes until the server closes.
  std::string rest() {
    std::string all;
    char buffer[4096];
    for (ssize_t got; (got = ::recv(socket_, buffer, sizeof buffer, 0)) > 0;) all.append(buffer, got);
    return all;
  }
  // Until `end` has come.
  std::string until(std::string_view end) {
    std::string all;
    char byte;
    while (!all.ends_with(end) && ::recv(socket_, &byte, 1, 0) == 1) all += byte;
    return all;
  }

 private:
  int socket_;
};

class HttpServerTest : public ::testing::Test {
 protected:
  HttpServerTest() {
    config_.address = {"127.0.0.1", 0};
    config_.threads = 4;
    config_.max_body_bytes = 1000;
    config_.io.header_timeout = milliseconds(300);
    config_.io.io_timeout = milliseconds(300);
    config_.keep_alive = milliseconds(200);
  }

  void start() {
    std::vector<Route> routes = {
        {"GET", "/hello",
         [](const Request& request) {
           return Reply{200, "text/plain", "hello " + request.query, {}};
         }},
        {"POST", "/echo",
         [](const Request& request) {
           return Reply{200, "text/plain", request.body, {}};
         }},
        {"GET", "/unchanged",
         [](const Request&) {
           return Reply{304, {}, {}, {}};
         }},
        {"POST", "/wait", [this](const Request& request) { return wait(request); }},
    };
    dispatcher_ = std::make_unique<Dispatcher>(std::move(routes), metrics_);
    server_ = std::make_unique<HttpServer>(config_, *dispatcher_, metrics_);
    server_->start();
  }

  // Until the test says so or the request is cancelled.
  Reply wait(const Request& request) {
    ++waiting_;
    std::unique_lock lock(mutex_);
    const bool released = released_.wait_until(lock, request.deadline.cancel_token(), request.deadline.end(),
                                               [this] { return release_; });
    lock.unlock();
    --waiting_;
    if (!released) {
      ++cancelled_;
      fail_deadline(request.deadline, "wait");
    }
    return {200, "text/plain", "released", {}};
  }
  void release() {
    const std::lock_guard lock(mutex_);
    release_ = true;
    released_.notify_all();
  }
  void until_waiting(int count) {
    while (waiting_ != count) std::this_thread::yield();
  }

  std::string ask(std::string_view text) {
    Client client(server_->port());
    client.say(text);
    return client.rest();
  }

  HttpConfig config_;
  Metrics metrics_{"test"};
  std::unique_ptr<Dispatcher> dispatcher_;
  std::mutex mutex_;
  std::condition_variable_any released_;
  bool release_ = false;
  std::atomic<int> waiting_ = 0, cancelled_ = 0;
  std::unique_ptr<HttpServer> server_;  // last: its threads use all of the above
};

TEST_F(HttpServerTest, OneRequest) {
  start();
  const std::string reply = ask("GET /hello?a=b HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(reply, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(reply, HasSubstr("\r\nContent-Length: 9\r\n"));
  EXPECT_THAT(reply, HasSubstr("\r\nDate: "));
  EXPECT_THAT(reply, HasSubstr("\r\n\r\nhello a=b"));
}

TEST_F(HttpServerTest, HeadHasNoBodyAndNotModifiedNoLength) {
  start();
  const std::string head = ask("HEAD /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(head, HasSubstr("\r\nContent-Length: 6\r\n"));
  EXPECT_TRUE(head.ends_with("\r\n\r\n"));
  const std::string unchanged = ask("GET /unchanged HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(unchanged, StartsWith("HTTP/1.1 304 "));
  EXPECT_EQ(unchanged.find("Content-Length"), std::string::npos);
}

TEST_F(HttpServerTest, ManyRequestsOnOneConnectionEvenAhead) {
  start();
  Client client(server_->port());
  client.say(
      "GET /hello?1 HTTP/1.1\r\nHost: h\r\n\r\nPOST /echo HTTP/1.1\r\nHost: h\r\nContent-Length: 3\r\n\r\nabc"
      "GET /hello?2 HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  const std::string replies = client.rest();
  EXPECT_THAT(replies, HasSubstr("\r\n\r\nhello 1HTTP/1.1 200 OK"));
  EXPECT_THAT(replies, HasSubstr("\r\n\r\nabcHTTP/1.1 200 OK"));
  EXPECT_TRUE(replies.ends_with("hello 2"));
}

TEST_F(HttpServerTest, TheLastRequestOfAConnectionIsAnnounced) {
  start();
  Client client(server_->port());
  std::string last;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(last.find("Connection: close"), std::string::npos) << i;
    client.say("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
    last = client.until("hello ");
  }
  EXPECT_THAT(last, HasSubstr("\r\nConnection: close\r\n"));
  EXPECT_EQ(client.rest(), "");
}

TEST_F(HttpServerTest, ChunkedBodies) {
  start();
  const std::string head =
      "POST /echo HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\nConnection: close\r\n\r\n";
  EXPECT_TRUE(ask(head + "3\r\nabc\r\n2\r\nde\r\n0\r\n\r\n").ends_with("\r\n\r\nabcde"));
  std::string large = head;
  for (int i = 0; i < 20; ++i) large += "64\r\n" + std::string(100, 'x') + "\r\n";
  EXPECT_THAT(ask(large + "0\r\n\r\n"), StartsWith("HTTP/1.1 413 "));
  EXPECT_THAT(ask(head + "zz\r\n"), StartsWith("HTTP/1.1 400 "));
}

TEST_F(HttpServerTest, ATooLongBodyIsRefusedFromItsHead) {
  start();
  // Nothing of the body is sent: the answer must not wait for it.
  const std::string reply =
      ask("POST /echo HTTP/1.1\r\nHost: h\r\nContent-Length: 1001\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_THAT(reply, StartsWith("HTTP/1.1 413 "));
  EXPECT_THAT(reply, HasSubstr("application/problem+json"));
  EXPECT_THAT(reply, HasSubstr("\r\nConnection: close\r\n"));
}

TEST_F(HttpServerTest, AllBodiesTogetherHaveALimit) {
  config_.max_bodies_bytes = 500;
  start();
  const std::string post = "POST /echo HTTP/1.1\r\nHost: h\r\nConnection: close\r\nContent-Length: ";
  EXPECT_THAT(ask(post + "600\r\n\r\n" + std::string(600, 'x')), StartsWith("HTTP/1.1 429 "));
  EXPECT_THAT(ask(post + "400\r\n\r\n" + std::string(400, 'x')), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(ask(post + "400\r\n\r\n" + std::string(400, 'x')), StartsWith("HTTP/1.1 200 "));
}

TEST_F(HttpServerTest, ExpectContinueIsAnswered) {
  start();
  Client client(server_->port());
  client.say(
      "POST /echo HTTP/1.1\r\nHost: h\r\nContent-Length: 3\r\nExpect: 100-continue\r\nConnection: "
      "close\r\n\r\n");
  EXPECT_THAT(client.until("\r\n\r\n"), StartsWith("HTTP/1.1 100 "));
  client.say("abc");
  EXPECT_TRUE(client.rest().ends_with("abc"));
}

TEST_F(HttpServerTest, ProtocolFaults) {
  start();
  const auto status = [this](std::string_view text) { return ask(text).substr(0, 12); };
  EXPECT_EQ(status("nonsense\r\n\r\n"), "HTTP/1.1 400");
  EXPECT_EQ(status("GET /hello HTTP/1.1\r\n\r\n"), "HTTP/1.1 400");
  EXPECT_EQ(status("GET /hello HTTP/2.0\r\nHost: h\r\n\r\n"), "HTTP/1.1 400");
  EXPECT_EQ(status("GET /" + std::string(9000, 'a') + " HTTP/1.1\r\nHost: h\r\n\r\n"), "HTTP/1.1 414");
  EXPECT_EQ(status("GET /" + std::string(90'000, 'a')), "HTTP/1.1 414");
  EXPECT_EQ(status("GET /hello HTTP/1.1\r\nHost: h\r\nX: " + std::string(90'000, 'a')), "HTTP/1.1 431");
  EXPECT_EQ(status("POST /echo HTTP/1.1\r\nHost: h\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\n"),
            "HTTP/1.1 400");
  EXPECT_EQ(status("POST /echo HTTP/1.1\r\nHost: h\r\nContent-Encoding: gzip\r\nContent-Length: 5\r\n\r\n"),
            "HTTP/1.1 415");
  EXPECT_EQ(status("POST /echo HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: gzip\r\n\r\n"), "HTTP/1.1 501");
  EXPECT_EQ(status("DELETE /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n"), "HTTP/1.1 405");
  EXPECT_EQ(status("TRACE /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n"), "HTTP/1.1 405");
  EXPECT_EQ(status("GET /none HTTP/1.0\r\n\r\n"), "HTTP/1.1 404");
}

TEST_F(HttpServerTest, APostWithoutALengthIsEmpty) {
  start();
  EXPECT_THAT(ask("POST /echo HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n"),
              HasSubstr("\r\nContent-Length: 0\r\n"));
}

TEST_F(HttpServerTest, ABodyWhereNoneBelongsEndsTheConnection) {
  start();
  // Were the body left in the stream, it would be read as a second request.
  const std::string reply =
      ask("GET /hello HTTP/1.1\r\nHost: h\r\nContent-Length: 41\r\n\r\nGET /hello?smuggled HTTP/1.1\r\nHost: "
          "h\r\n\r\n");
  EXPECT_THAT(reply, HasSubstr("\r\nConnection: close\r\n"));
  EXPECT_EQ(reply.find("smuggled"), std::string::npos);
}

TEST_F(HttpServerTest, RangesAreNotApplied) {
  start();
  std::string many = "bytes=0-";
  for (int i = 0; i < 1900; ++i) many += ",0-";  // nearly the longest header there can be
  for (const std::string& range : {many, std::string("bytes=5-1"), std::string("lines=1"), std::string()}) {
    EXPECT_THAT(ask("GET /hello HTTP/1.1\r\nHost: h\r\nrAnge: " + range + "\r\nConnection: close\r\n\r\n"),
                StartsWith("HTTP/1.1 200 "))
        << range.substr(0, 20);
  }
}

TEST_F(HttpServerTest, RequestIds) {
  start();
  const std::string get = "GET /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\nX-Request-Id: ";
  EXPECT_THAT(ask(get + "mine-1\r\n\r\n"), HasSubstr("\r\nX-Request-Id: mine-1\r\n"));
  const std::string reply = ask(get + "a%0d%0aSet-Cookie: x\r\n\r\n");
  EXPECT_EQ(reply.find("Set-Cookie"), std::string::npos);
}

TEST_F(HttpServerTest, SlowHeadsAndBodiesAreCutOff) {
  start();
  EXPECT_THAT(ask("GET /hello HTTP/1.1\r\nHost"), StartsWith("HTTP/1.1 408 "));
  EXPECT_THAT(ask("POST /echo HTTP/1.1\r\nHost: h\r\nContent-Length: 10\r\n\r\nabc"),
              StartsWith("HTTP/1.1 408 "));
}

TEST_F(HttpServerTest, SilentConnectionsGiveWayToOthers) {
  config_.io.header_timeout = config_.io.io_timeout = std::chrono::minutes(10);
  start();
  std::vector<std::unique_ptr<Client>> silent;
  for (int i = 0; i < 10; ++i) {
    silent.push_back(std::make_unique<Client>(server_->port()));
    silent.back()->say(i % 2 == 0 ? "GET /hel"
                                  : "POST /echo HTTP/1.1\r\nHost: h\r\nContent-Length: 9\r\n\r\nab");
  }
  // Without pressure they would be waited for ten minutes: this test would run into its own time limit.
  EXPECT_THAT(ask("GET /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 200 "));
}

TEST_F(HttpServerTest, TooManyConnectionsAreRefused) {
  config_.threads = 1;
  config_.max_connections = 1;
  start();
  Client working(server_->port());
  working.say("POST /wait HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  until_waiting(1);
  Client queued(server_->port());
  queued.say("GET /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n");
  // Connections are accepted in order, so the third finds the second waiting.
  const std::string refused = ask("GET /hello HTTP/1.1\r\nHost: h\r\n\r\n");
  EXPECT_THAT(refused, StartsWith("HTTP/1.1 429 "));
  EXPECT_THAT(refused, HasSubstr("\r\nRetry-After: 1\r\n"));
  release();
  EXPECT_THAT(queued.rest(), StartsWith("HTTP/1.1 200 "));
}

TEST_F(HttpServerTest, AClientThatLeavesCancelsItsRequest) {
  start();
  Client client(server_->port());
  client.say("POST /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  until_waiting(1);
  client.hang_up();
  until_waiting(0);
  EXPECT_EQ(cancelled_, 1);
}

TEST_F(HttpServerTest, AClientThatOnlySaysNoMoreIsAnswered) {
  start();
  Client client(server_->port());
  client.say("POST /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  client.say_no_more();
  EXPECT_EQ(client.until("\r\n\r\n"), "HTTP/1.1 102 Processing\r\n\r\n");
  EXPECT_EQ(cancelled_, 0);
  release();
  EXPECT_TRUE(client.rest().ends_with("released"));
}

TEST_F(HttpServerTest, AnOldClientThatSaysNoMoreIsGone) {
  start();
  Client client(server_->port());
  client.say("POST /wait HTTP/1.0\r\n\r\n");
  client.say_no_more();
  EXPECT_THAT(client.rest(), HasSubstr(" 504 "));  // not even a sign of life before it
  EXPECT_EQ(cancelled_, 1);
}

TEST_F(HttpServerTest, DrainingLetsRequestsEnd) {
  start();
  Client client(server_->port());
  client.say("POST /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  until_waiting(1);
  std::jthread stopping([this] { server_->stop(std::chrono::minutes(5)); });
  release();
  const std::string reply = client.rest();
  EXPECT_THAT(reply, StartsWith("HTTP/1.1 200 "));
  EXPECT_TRUE(reply.ends_with("released"));
}

TEST_F(HttpServerTest, DrainingEndsSomeday) {
  start();
  Client client(server_->port());
  client.say("POST /wait HTTP/1.1\r\nHost: h\r\n\r\n");
  until_waiting(1);
  server_->stop(milliseconds(0));
  EXPECT_THAT(client.rest(), StartsWith("HTTP/1.1 504 "));
}

TEST_F(HttpServerTest, AnAddressInUseIsAnError) {
  start();
  HttpConfig same = config_;
  same.address.port = server_->port();
  EXPECT_THROW(HttpServer(same, *dispatcher_, metrics_), Error);
}

TEST_F(HttpServerTest, ALostListenerIsOpenedAgain) {
  start();
  const int port = server_->port();
  int lost = 0;
  for (int socket = 3; socket < 256; ++socket) {
    int listening = 0;
    socklen_t size = sizeof listening;
    const bool is_socket = ::getsockopt(socket, SOL_SOCKET, SO_ACCEPTCONN, &listening, &size) == 0;
    if (is_socket && listening && ::shutdown(socket, SHUT_RDWR) == 0) ++lost;  // accept() now fails
  }
  ASSERT_EQ(lost, 1);
  while (!can_connect(port)) std::this_thread::yield();
  EXPECT_THAT(ask("GET /hello HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 200 "));
}

TEST_F(HttpServerTest, TimeEndsWithAProblem) {
  config_.timeout = milliseconds(1);
  start();
  EXPECT_THAT(ask("POST /wait HTTP/1.1\r\nHost: h\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 504 "));
}

}  // namespace
}  // namespace furnace
