// HTTP as plain values: what routes take and return. No socket, no library.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/base/deadline.hpp"
#include "server/access.hpp"
#include "server/file_body.hpp"
#include "server/trace_context.hpp"

namespace furnace {

// Header names compare without case (RFC 9110 section 5.1).
struct HeaderLess {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const {
    return std::lexicographical_compare(
        a.begin(), a.end(), b.begin(), b.end(),
        [](unsigned char x, unsigned char y) { return std::tolower(x) < std::tolower(y); });
  }
};

// Where a body goes as it comes, for a route that does not want it in memory.
// Threads: one.
class BodySink {
 public:
  virtual ~BodySink() = default;
  // The next bytes. Errors: any; the request is refused with it, and nothing more comes.
  virtual void take(std::string_view bytes) = 0;
};

// Who asks, as the gate found: nobody in particular where no keys are asked for.
struct Client {
  std::string name;
  Scopes scopes = scope::kAll;
  std::int64_t asset_bytes = 0;  // what its assets may have together; 0: any
};

// Threads: one. Owns: its bytes.
struct Request {
  std::string method;                                      // "GET", ...
  std::string path;                                        // percent-decoded, without query
  std::string query;                                       // as sent, without "?"
  std::map<std::string, std::string, HeaderLess> headers;  // repeated fields joined by ", "
  std::string body;
  std::shared_ptr<BodySink> sink;  // has taken the body instead, all of it; null: it is in `body`
  std::string id;                  // request id: goes into the log, the reply and problem documents
  TraceContext trace;              // likewise
  Deadline deadline;
  Client client = {};

  std::string_view header(std::string_view name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string_view{} : std::string_view{found->second};
  }
};

// Threads: a value.
struct ByteRange {
  std::int64_t first = 0, end = 0;  // `end` is behind the last

  std::int64_t size() const { return end - first; }
};

struct Reply {
  int status = 200;
  std::string media_type;  // empty: no Content-Type
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
  // In place of a body: gives the next piece, waits for it on the connection's thread; false with or after the last one.
  std::function<bool(std::string& piece)> stream = {};
  std::shared_ptr<const FileBody> file = {};  // instead of `body`
  std::optional<ByteRange> part = {};         // of body or file, which alone is sent
  int renders = 1;                            // that a key's day is charged, of a route that draws

  Reply& with(std::string name, std::string value) {
    headers.emplace_back(std::move(name), std::move(value));
    return *this;
  }
};

}  // namespace furnace
