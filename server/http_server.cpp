// cpp-httplib 0.11 and how it is kept in bounds. Of the library we use the accept loop, the parser of request
// lines, headers and chunks, and the writer of responses. What it leaves open is closed here, in one hook
// (receive_head) that sees each request before the library acts on it:
//   its job list has no bound                        -> BoundedPool
//   its socket stream waits per byte, not in total    -> HttpStream over SocketIo, which also bounds the length
//   of a head a refused body is still read to its end           -> refused from its headers, connection
//   closed after a lingering read chunked and compressed bodies escape its limit    -> counted as they come;
//   Content-Encoding is refused a POST without a length reads until the peer ends -> Content-Length: 0 Range
//   is applied to any body, as often as asked   -> its field is kept from it routes and multipart heads are matched
//   by regex   -> one route; bodies come to us raw SO_REUSEPORT lets two servers share a port        ->
//   SO_REUSEADDR only
#include "server/http_server.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <httplib.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"
#include "server/body_receiver.hpp"
#include "server/byte_range.hpp"
#include "server/preferences.hpp"
#include "server/framing.hpp"
#include "server/http_stream.hpp"
#include "server/http_translation.hpp"
#include "server/in_flight.hpp"
#include "server/metrics.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr int kBacklog = 512;  // the library's own is 5
constexpr int kMaxRequestsPerConnection = 1000;
constexpr milliseconds kWatchPeriod{100};  // how soon a client's leaving is seen
constexpr milliseconds kLinger{1000}, kHurriedLinger{100};
constexpr std::int64_t kChunkOverhead = 64 << 10;

// One request as it passes through the library's hooks, on the stack of its connection's thread.
struct Exchange {
  SocketIo& io;
  BodyReceiver body;
  Request request = {};
  Framing framing = {};
  bool head_complete = false;
  bool takes_interim = false;  // RFC 9110 section 15.2: clients of HTTP/1.0 know no 1xx
  bool replied = false;
  bool close = false;       // the connection cannot carry another request
  bool unwanted = false;    // the body is not read
  bool has_ranges = false;  // the reply says that parts of it may be had

  // Before the reply is sent: a client that has it may count on the room.
  void drop_body() {
    body.give_room_back();
    request.body = {};
    request.sink = {};
  }
};

thread_local Exchange* current_exchange = nullptr;
thread_local bool refusing_connections = false;

// What ended a read: time, `too_much` or something else.
Refusal refusal_for(ReadFault fault, Refusal too_much, Refusal otherwise) {
  if (fault == ReadFault::kTimeout) return {408, "The request came too slowly."};
  return fault == ReadFault::kTooMuch ? too_much : otherwise;
}

// Threads that serve connections; those beyond `max_waiting` are refused on the accepting thread.
class BoundedPool : public httplib::ThreadPool {
 public:
  BoundedPool(int threads, int max_waiting, std::function<void()> on_tick)
      : ThreadPool(threads), threads_(threads), max_waiting_(max_waiting), on_tick_(std::move(on_tick)) {}

  void enqueue(std::function<void()> serve) override {
    on_tick_();
    if (waiting_ >= max_waiting_) {
      refusing_connections = true;
      serve();
      refusing_connections = false;
      return;
    }
    ++waiting_;
    ThreadPool::enqueue([this, serve = std::move(serve)] {
      ++busy_;
      --waiting_;
      serve();
      --busy_;
    });
  }
  void on_idle() override { on_tick_(); }

  // Connections wait and every thread is taken.
  bool under_pressure() const { return waiting_ > 0 && busy_ >= threads_; }

 private:
  const int threads_;
  const int max_waiting_;
  std::function<void()> on_tick_;
  std::atomic<int> waiting_ = 0;
  std::atomic<int> busy_ = 0;
};

// A client may ask for less time than there is; for a job it only says how long it would wait for it.
milliseconds time_for(const Request& request, milliseconds timeout) {
  const Preferences prefer = parse_preferences(request.header("Prefer"));
  return prefer.wait && !prefer.respond_async ? std::min(timeout, milliseconds(*prefer.wait)) : timeout;
}

}  // namespace

struct HttpServer::State : private httplib::Server {
  State(const HttpConfig& config, const Dispatcher& dispatcher, Metrics& metrics, const TlsCertificate* tls);

  void start();
  void stop_serving(milliseconds drain);

  int port = 0;

 private:
  bool process_and_close_socket(socket_t socket) override;
  void bind();
  void install_hooks();
  void listen_again();
  void serve_connection(int socket);
  bool serve_request(SocketIo& io, bool last);
  void receive_head(httplib::Request& head, Exchange& exchange);
  bool receive_body(const httplib::ContentReader& reader, Exchange& exchange, httplib::Response& out);
  void answer(Exchange& exchange, httplib::Response& out);
  void refuse(Exchange& exchange, const Refusal& refusal, httplib::Response& out);
  void refuse_without_head(Exchange& exchange);
  void refuse_connection(int socket);
  void cancel_abandoned();

  const HttpConfig config_;
  const Dispatcher& dispatcher_;
  Metrics& metrics_;
  const TlsCertificate* const tls_;
  const std::string too_many_connections_, needs_tls_;
  BoundedPool* pool_ = nullptr;  // the library owns it while it listens
  InFlight in_flight_;
  std::atomic<bool> stopping_ = false;
  std::atomic<std::int64_t> bodies_bytes_ = 0;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::atomic<bool> listening_ = false;
  std::thread accept_thread_;
};

HttpServer::State::State(const HttpConfig& config, const Dispatcher& dispatcher, Metrics& metrics,
                         const TlsCertificate* tls)
    : config_(config),
      dispatcher_(dispatcher),
      metrics_(metrics),
      tls_(tls),
      too_many_connections_(raw_response(dispatcher.overloaded())),
      needs_tls_(raw_response(dispatcher.needs_tls())) {
  install_hooks();
  bind();
}

void HttpServer::State::bind() {
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  set_tcp_nodelay(true);
  set_idle_interval(0, std::chrono::microseconds(kWatchPeriod).count());
  set_keep_alive_timeout(
      std::chrono::ceil<std::chrono::seconds>(config_.keep_alive).count());  // told to clients only
  set_keep_alive_max_count(kMaxRequestsPerConnection);
  const Address& address = config_.address;
  port = address.port == 0                          ? bind_to_any_port(address.host)
         : bind_to_port(address.host, address.port) ? address.port
                                                    : -1;
  if (port < 0) {
    fail(ErrorCode::kUnprocessable, fmt::format("cannot listen on {}:{}: {}", address.host, address.port,
                                                std::generic_category().message(errno)));
  }
  ::listen(svr_sock_, kBacklog);
}

void HttpServer::State::install_hooks() {
  new_task_queue = [this] {
    return pool_ = new BoundedPool(config_.threads, config_.max_connections, [this] { cancel_abandoned(); });
  };
  set_pre_routing_handler([this](const httplib::Request& head, httplib::Response& out) {
    Exchange& exchange = *current_exchange;
    if (exchange.framing.refusal.status != 0) {
      refuse(exchange, exchange.framing.refusal, out);
    } else if (!has_request_body(head.method) || exchange.unwanted) {
      answer(exchange, out);
    }
    return exchange.replied ? HandlerResponse::Handled : HandlerResponse::Unhandled;
  });
  const HandlerWithContentReader with_body = [this](const httplib::Request&, httplib::Response& out,
                                                    const httplib::ContentReader& reader) {
    if (receive_body(reader, *current_exchange, out)) answer(*current_exchange, out);
  };
  Post("/", with_body).Put("/", with_body).Patch("/", with_body);
  set_error_handler(HandlerWithResponse([this](const httplib::Request&, httplib::Response& out) {
    Exchange& exchange = *current_exchange;
    if (exchange.replied) return HandlerResponse::Unhandled;
    refuse(exchange,
           refusal_for(exchange.io.fault(), {431, "The request's headers are too long."},
                       {out.status, "The request's line or headers are malformed or too long."}),
           out);
    return HandlerResponse::Handled;
  }));
  const auto hsts_s = std::chrono::duration_cast<std::chrono::seconds>(config_.hsts_max_age).count();
  set_post_routing_handler(
      [says_hsts = tls_ != nullptr && hsts_s > 0, hsts = fmt::format("max-age={}", hsts_s)](
          const httplib::Request&, httplib::Response& out) {
        if (says_hsts) out.set_header("Strict-Transport-Security", hsts);
        if (!current_exchange->has_ranges) out.headers.erase("Accept-Ranges");  // the library's
        if (out.status == 304)
          out.headers.erase("Content-Length");  // the picture's is not known (RFC 9110 section 15.4.5)
        if (current_exchange->close) {
          out.headers.erase("Keep-Alive");
          out.headers.erase("Connection");
          out.set_header("Connection", "close");
        }
        out.set_header("Date", http_date());
      });
}

void HttpServer::State::start() {
  listening_ = true;
  accept_thread_ = std::thread([this] {
    while (!stopping_) {
      listen_after_bind();
      if (!stopping_) listen_again();
    }
    const std::lock_guard lock(mutex_);
    listening_ = false;
    ended_.notify_all();
  });
  while (!is_running() && listening_) std::this_thread::yield();
}

void HttpServer::State::listen_again() {
  log::error("server.listener_lost", {{"detail", std::generic_category().message(errno)}});
  while (!stopping_ && !bind_to_port(config_.address.host, port)) std::this_thread::sleep_for(kWatchPeriod);
}

void HttpServer::State::stop_serving(milliseconds drain) {
  if (!accept_thread_.joinable()) return;
  stopping_ = true;
  const auto end = Clock::now() + drain;
  {
    std::unique_lock lock(mutex_);
    do {
      // Once it has taken this, the accepting thread waits for its pool. It may just be binding again and not take it yet.
      if (is_running() && svr_sock_ != INVALID_SOCKET) Server::stop();
      if (Clock::now() < end) {
        cancel_abandoned();
      } else {
        in_flight_.cancel_all();
      }
    } while (!ended_.wait_for(lock, kWatchPeriod, [this] { return !listening_; }));
  }
  accept_thread_.join();
}

void HttpServer::State::cancel_abandoned() {
  const int gone = in_flight_.cancel_abandoned();
  if (gone > 0) metrics_.clients_gone.Increment(gone);
}

bool HttpServer::State::process_and_close_socket(socket_t socket) {
  if (refusing_connections) {
    refuse_connection(socket);
  } else {
    // The library parses heads outside of its own catch.
    try {
      serve_connection(socket);
    } catch (const std::exception& stray) {
      log::error("connection.failed", {{"detail", stray.what()}});
    }
  }
  ::close(socket);
  return true;
}

void HttpServer::State::refuse_connection(int socket) {
  metrics_.connections_refused.Increment();
  if (tls_ != nullptr) return;  // no keys to say it with
  SocketIo io(socket, config_.io);
  io.write(too_many_connections_.data(),
           too_many_connections_.size());  // fits the empty send buffer: no waiting here
  io.linger(milliseconds(0));
}

void HttpServer::State::serve_connection(int socket) {
  SocketIo io(socket, config_.io, tls_ ? tls_->session(socket) : nullptr);
  const auto opened = Clock::now();
  const auto too_late = [this, opened] {
    return stopping_ || (pool_->under_pressure() && Clock::now() - opened > std::chrono::seconds(1));
  };
  const Greeting greeting = io.handshake(too_late);
  if (greeting == Greeting::kPlainHttp) {
    io.write(needs_tls_.data(), needs_tls_.size());
    io.linger(kHurriedLinger);
  }
  bool more = greeting == Greeting::kReady && io.wait_for_request(config_.io.header_timeout, too_late);
  for (int left = kMaxRequestsPerConnection - 1; more && serve_request(io, left == 0); --left) {
    more = io.wait_for_request(config_.keep_alive, [this] { return stopping_ || pool_->under_pressure(); });
  }
}

// Returns whether the connection may carry another request.
bool HttpServer::State::serve_request(SocketIo& io, bool last) {
  Exchange exchange{io, {bodies_bytes_, config_.max_bodies_bytes}};
  current_exchange = &exchange;
  HttpStream stream(io);
  io.begin_head([this] { return pool_->under_pressure(); });
  bool closed_by_header = false;
  last = last || stopping_ || pool_->under_pressure();
  const bool written = process_request(stream, last, closed_by_header, [&](httplib::Request& head) {
    if (std::string range = stream.end_head(); !range.empty())
      head.headers.emplace("Range", std::move(range));
    receive_head(head, exchange);
  });
  if (!exchange.replied) refuse_without_head(exchange);
  if (exchange.replied && (exchange.close || !exchange.head_complete))
    io.linger(pool_->under_pressure() ? kHurriedLinger : kLinger);
  return written && exchange.head_complete && !exchange.close && !closed_by_header && !last;
}

// Takes what we need from a head, then leaves the library only what it must know to read the body.
void HttpServer::State::receive_head(httplib::Request& head, Exchange& exchange) {
  exchange.head_complete = true;
  exchange.takes_interim = head.version == "HTTP/1.1";
  Request& request = exchange.request;
  request.method = head.method;
  request.path = head.path;
  request.query =
      head.target.find('?') == std::string::npos ? "" : head.target.substr(head.target.find('?') + 1);
  request.headers = joined_headers(head.headers);
  request.id =
      is_sane_request_id(request.header("X-Request-Id")) ? request.headers["X-Request-Id"] : new_request_id();
  request.trace = trace_of(request.header("traceparent"));
  const Incoming incoming = dispatcher_.receive(request);
  const std::int64_t max_body_bytes = incoming.max_bytes > 0 ? incoming.max_bytes : config_.max_body_bytes;
  request.sink = incoming.sink;
  exchange.unwanted = incoming.is_unwanted;
  exchange.body.allow(max_body_bytes);
  exchange.framing = read_framing(request, head.version, max_body_bytes);

  const Framing& framing = exchange.framing;
  const bool announces_body = framing.chunked || framing.content_length > 0;
  exchange.close = framing.refusal.status != 0 ||
                   (announces_body && (exchange.unwanted || !has_request_body(request.method)));

  httplib::Headers kept;
  kept.emplace("Connection", std::string(request.header("Connection")));
  if (framing.chunked) {
    kept.emplace("Transfer-Encoding", "chunked");
  } else {
    kept.emplace("Content-Length", std::to_string(framing.content_length));
  }
  if (announces_body && !exchange.close && request.headers.contains("Expect"))
    kept.emplace("Expect", "100-continue");
  head.headers = std::move(kept);
  head.path = "/";
  exchange.io.begin_body(max_body_bytes + max_body_bytes / 4 + kChunkOverhead);
}

bool HttpServer::State::receive_body(const httplib::ContentReader& reader, Exchange& exchange,
                                     httplib::Response& out) {
  const bool complete = reader([&](const char* data, size_t size) {
    return exchange.body.take({data, size}, exchange.request);
  });
  if (complete) return true;
  Refusal refusal = exchange.body.refusal();
  if (refusal.status == 0) {
    refusal = refusal_for(exchange.io.fault(), {413, "The body is too large."},
                          {400, "The body ended early or its chunks are malformed."});
  }
  refuse(exchange, refusal, out);
  return false;
}

void HttpServer::State::answer(Exchange& exchange, httplib::Response& out) {
  const InFlight::Entry entry(in_flight_, exchange.io, exchange.takes_interim);
  exchange.request.deadline = Deadline(time_for(exchange.request, config_.timeout), entry.token());
  Reply reply = dispatcher_.handle(std::move(exchange.request));
  exchange.has_ranges = says_ranges(reply);
  fill(out, std::move(reply));
  exchange.drop_body();
  exchange.replied = true;
}

void HttpServer::State::refuse(Exchange& exchange, const Refusal& refusal, httplib::Response& out) {
  if (exchange.request.id.empty()) exchange.request.id = new_request_id();
  exchange.drop_body();
  exchange.close = true;
  exchange.replied = true;
  out = httplib::Response();
  out.version = "HTTP/1.1";
  fill(out, dispatcher_.refuse(exchange.request, refusal));
}

// The library gave up silently: the head never came to its end.
void HttpServer::State::refuse_without_head(Exchange& exchange) {
  const Refusal refusal = refusal_for(exchange.io.fault(), {414, "The request's line is too long."}, {});
  if (refusal.status == 0) return;
  exchange.request.id = new_request_id();
  const std::string text = raw_response(dispatcher_.refuse(exchange.request, refusal));
  exchange.replied = exchange.io.write(text.data(), text.size());
}

HttpServer::HttpServer(const HttpConfig& config, const Dispatcher& dispatcher, Metrics& metrics,
                       const TlsCertificate* tls)
    : state_(std::make_unique<State>(config, dispatcher, metrics, tls)) {}
HttpServer::~HttpServer() {
  state_->stop_serving(milliseconds(0));
}

int HttpServer::port() const {
  return state_->port;
}
void HttpServer::start() {
  state_->start();
}
void HttpServer::stop(milliseconds drain) {
  state_->stop_serving(drain);
}

}  // namespace furnace
