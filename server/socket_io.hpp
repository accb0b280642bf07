// One connection's bytes under limits of time and amount, so that nobody can hold a thread by being slow.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <utility>

#include "renderer/base/deadline.hpp"
#include "server/tls.hpp"

namespace furnace {

struct IoLimits {
  std::chrono::milliseconds header_timeout{5000};  // from a request's first byte to the end of its headers
  std::chrono::milliseconds io_timeout{10000};     // longest standstill within a body
  std::int64_t min_bytes_per_s = 16 << 10;         // slower than this, on the whole, is cut off
  std::int64_t max_head_bytes = 32 << 10;
};

enum class Greeting { kReady, kGone, kPlainHttp };

enum class ReadFault { kNone, kClosed, kTimeout, kTooMuch };

// Threads: one. Owns: the TLS session; the socket is its caller's.
class SocketIo {
 public:
  // Without `tls` bytes go over the wire as they are.
  SocketIo(int socket, const IoLimits& limits, std::unique_ptr<TlsSession> tls = nullptr)
      : socket_(socket), limits_(limits), tls_(std::move(tls)) {}

  // Agrees on keys with the client, within the time that a head may take, or until `give_up` says so. kGone: there will be no
  // request. kPlainHttp: the client knows nothing of keys; from now on bytes go over the wire as they are.
  Greeting handshake(const std::function<bool()>& give_up);

  // Waits for a request's first byte until `patience` ends or `give_up` says so; false: there will be none.
  bool wait_for_request(std::chrono::milliseconds patience, const std::function<bool()>& give_up);

  // Limits of what is read next: a head, after whose first second `hurry` may end it, or a body of at most
  // `max_bytes`, which `hurry` ends when it is slow on the whole, whatever the pauses it may make otherwise.
  void begin_head(std::function<bool()> hurry);
  void begin_body(std::int64_t max_bytes);

  ssize_t read(char* out, std::size_t size);  // > 0, or -1 with fault()
  bool write(const char* data, std::size_t size);
  ReadFault fault() const { return fault_; }

  // Whether there is still somebody to answer. A client that has only shut down its sending side looks like one that has
  // left until something is sent to it, so with `takes_interim` (HTTP/1.1) it is told now and then that it is not forgotten.
  // While the request is being answered; by any one thread then.
  bool client_listens(bool takes_interim);

  // Says that no more will be sent and swallows what still comes: closing over unread bytes would reset the
  // connection and take the answer with it.
  void linger(std::chrono::milliseconds patience);

  int socket() const { return socket_; }

 private:
  TlsSession::Progress receive(char* out, std::size_t size);
  TlsSession::Progress send(const char* data, std::size_t size);
  bool fill();
  bool out_of_time() const;
  bool is_too_slow(Clock::time_point begin, std::int64_t bytes) const;

  int socket_;
  IoLimits limits_;
  std::unique_ptr<TlsSession> tls_;
  std::string buffer_;
  std::size_t next_ = 0;  // first byte of buffer_ not yet read
  bool in_head_ = false;
  std::function<bool()> hurry_;
  Clock::time_point begin_{};
  std::int64_t received_bytes_ = 0;  // of this head or body
  std::int64_t max_bytes_ = 0;
  ReadFault fault_ = ReadFault::kNone;
  Clock::time_point next_sign_{};  // of life, to a client that sends no more
};

}  // namespace furnace
