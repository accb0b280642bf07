// A listening socket whose requests go through a Dispatcher. The only file that knows the HTTP library is
// http_server.cpp.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "server/config.hpp"
#include "server/dispatcher.hpp"
#include "server/socket_io.hpp"

namespace furnace {

struct HttpConfig {
  Address address;
  int threads = 8;            // one per connection being served
  int max_connections = 256;  // waiting for a thread
  std::int64_t max_body_bytes = 64ll << 20;
  std::int64_t max_bodies_bytes = 512ll << 20;  // of all requests together
  std::chrono::milliseconds timeout{30'000};    // a request's Deadline, from its last byte on
  std::chrono::milliseconds keep_alive{1'000};
  IoLimits io;
  std::chrono::milliseconds hsts_max_age{0};  // RFC 6797; 0: not said
};

// Threads: its own; the members are for one owner thread.
// Owns: the sockets, the threads that accept and serve, and the Deadlines of requests in flight.
class HttpServer {
 public:
  // Binds and listens. Errors: kUnprocessable when the address cannot be had. `dispatcher`, `metrics` and `tls` outlive
  // the server; without `tls` it speaks plain HTTP.
  HttpServer(const HttpConfig& config, const Dispatcher& dispatcher, Metrics& metrics,
             const TlsCertificate* tls = nullptr);
  ~HttpServer();  // stop(0)

  int port() const;
  void start();
  // Accepts nothing more, waits for requests in flight until `drain` ends, then cancels those left and waits
  // for their replies.
  void stop(std::chrono::milliseconds drain);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace furnace
