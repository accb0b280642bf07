// Before a route's handler: does the URL fit, is its signature right, may this key, has it had enough? The one place.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/access.hpp"
#include "server/cors.hpp"
#include "server/http_types.hpp"

namespace furnace {

struct GateConfig {
  std::string api_keys_file;  // empty: whoever comes may do all
  std::string url_keys_file;  // empty: image URLs are as other routes
  std::string cors_origins;
  std::int64_t max_url_bytes = 8192;  // path and query
};

// What time it is; other clocks are for tests.
struct GateClock {
  std::function<Clock::time_point()> steady = [] { return Clock::now(); };
  std::function<std::int64_t()> unix_s = [] {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::int64_t(std::chrono::duration_cast<std::chrono::seconds>(now).count());
  };
};

// What a request asks for, as its route says it.
struct Wish {
  Scopes scopes = scope::kOpen;
  bool draws = false;  // counts as a render of the day
};

struct Entry {
  int refused = 0;     // the status, or 0
  std::string detail;  // why, for the client
  Client client = {};
  bool counted = false;                                      // as a render of the day
  std::vector<std::pair<std::string, std::string>> headers;  // of the reply, refused or not
};

// Threads: any. Owns: what its files say, and what each key has used.
class Gate {
 public:
  // Errors: those of read_key_file, parse_api_keys and parse_url_keys.
  explicit Gate(GateConfig config, GateClock clock = {});
  ~Gate();

  // Reads the files again; what keys of the same name have used stays. On an Error all is as before.
  void reload();

  Entry enter(const Wish& wish, const Request& request);
  // As enter, but nothing is counted: the body is yet to come.
  Entry look(const Wish& wish, const Request& head) { return check(wish, head, false); }
  // What was not drawn is not a render of the day; what turned out to be several is so many, also beyond the day's.
  void leave(const Entry& entry, int status, int renders);

  const Cors& cors() const { return cors_; }

 private:
  struct State;

  Entry check(const Wish& wish, const Request& request, bool charges);

  const GateConfig config_;
  const GateClock clock_;
  const Cors cors_;
  std::unique_ptr<State> state_;
};

}  // namespace furnace
