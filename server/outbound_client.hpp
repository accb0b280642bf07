// The one door by which the server calls others.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "server/outbound_url.hpp"

namespace furnace {

struct OutboundConfig {
  std::chrono::milliseconds connect_timeout{3000};
  std::chrono::milliseconds timeout{5000};  // of all hops together
  std::int64_t max_bytes = 64ll << 20;      // of the answer's body
  int max_redirects = 3;
  std::string user_agent;
  std::string ca_file;  // PEM, in place of the system's certificates; "": the system's
};

struct OutboundRequest {
  OutboundUrl url;
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::optional<std::string> body = {};  // then it is a POST; none: a GET
};

enum class OutboundFault {
  kNone,     // there is an answer, of whatever status
  kRefused,  // the allow-list or the address policy forbids it, of the first URL or of one it was redirected to
  kUnreachable,  // name, connection or certificate failed, or the connection broke
  kTimeout,
  kCancelled,  // the deadline passed, or who asked is gone
  kTooLarge,   // `status` is that of the answer
  kBadAnswer,  // cut off, coded, redirected too often or to nowhere
};
std::string_view name_of(OutboundFault fault);  // "refused", ...: stable, for metrics and the log

struct OutboundAnswer {
  OutboundFault fault = OutboundFault::kNone;
  std::string detail;  // of a fault; for the log alone: it may name addresses
  int status = 0;      // 0: none came
  std::string body;
  std::string etag;  // as sent, "" without one
  std::int64_t retry_after_s = 0;
};

// Policy: http and https by the allow-list; the address that a name resolved to is judged when the socket is made, at every
// hop; no proxies, cookies, credentials or netrc; content codings are neither asked for nor taken.
// Threads: any; each call has its own connection and waits on its caller's thread. Owns: nothing but its configuration.
class OutboundClient {
 public:
  OutboundClient(AllowList allowed, OutboundConfig config);

  const AllowList& allowed() const { return allowed_; }
  // Never throws for what the network does.
  OutboundAnswer send(const OutboundRequest& request, const Deadline& deadline) const;

 private:
  OutboundAnswer send_once(const OutboundRequest& request, const OutboundUrl& url, Clock::time_point end,
                           const Deadline& deadline, std::string& location) const;

  AllowList allowed_;
  OutboundConfig config_;
};

}  // namespace furnace
