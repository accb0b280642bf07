// HTTP/1.1 as text: what a request's head says about its body and whether it can be believed (RFC 9112 section 6), and
// the few things we write ourselves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/base/error.hpp"
#include "server/http_types.hpp"

namespace furnace {

// Why a request is refused before a route sees it; status 0: it is not.
struct Refusal {
  int status = 0;
  std::string detail;
  std::optional<Error> error =
      std::nullopt;  // what came of a body that a route took in; its status is `status`
};

struct Framing {
  Refusal refusal;
  std::int64_t content_length = 0;  // bytes; of a chunked body: 0
  bool chunked = false;
};

Framing read_framing(const Request& head, std::string_view http_version, std::int64_t max_body_bytes);

bool has_request_body(std::string_view method);  // whether one is read

std::string http_date();  // now, as in a Date field

// A whole response as text, for replies that the HTTP library cannot write; ends the connection.
std::string raw_response(const Reply& reply);

// A client's X-Request-Id is kept when it is plain enough for logs and headers.
bool is_sane_request_id(std::string_view id);
std::string new_request_id();

}  // namespace furnace
