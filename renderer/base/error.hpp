// The one exception of Furnace: an Error ends a request, never the process.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace furnace {

// Each code maps to one HTTP status (api/problem.cpp).
enum class ErrorCode {
  kInvalidRequest,    // malformed syntax: JSON, multipart, query                         400
  kNotFound,          // no such route, asset or name                                     404
  kMethodNotAllowed,  // the route exists, the method does not                            405
  kNotAcceptable,     // no representation satisfies Accept                               406
  kTooLarge,          // body, image or count over a limit                                413
  kUnsupportedMedia,  // a media type or file format that is not read                     415
  kUnprocessable,     // well-formed but wrong: schema violations, broken assets          422
  kOverloaded,        // the queue is full, try again                                     429
  kInternal,          // our mistake                                                      500
  kBadGateway,        // another server, asked on the client's behalf, failed              502
  kGpuUnavailable,    // no working GL context                                            503
  kDeadlineExceeded,  // the request's time is over                                       504
  kStorage,           // the disk refused                                                 507
};

// One fault in the client's own document.
struct Problem {
  std::string pointer;  // RFC 6901 JSON pointer into the client's document; "" is the whole document
  std::string message;  // what is wrong and what to do, for the client
};

struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;               // for the client
  std::string pointer;               // JSON pointer into the client's document, may be empty
  std::string detail;                // for the log only
  std::vector<Problem> problems;     // all faults found, when there may be several
  std::vector<std::string> context;  // breadcrumbs, innermost first
};

[[noreturn]] void fail(ErrorCode code, std::string message, std::string pointer = {},
                       std::string detail = {});

// "unprocessable", "too-large", ...: stable, used in problem types and logs.
std::string_view error_code_name(ErrorCode code);

// Adds a breadcrumb to every Error that leaves `body`.
// Example: with_context("texture 3", [&] { return decode(bytes); })
template <class Body>
auto with_context(std::string_view breadcrumb, Body&& body) -> decltype(body()) {
  try {
    return body();
  } catch (Error& error) {
    error.context.emplace_back(breadcrumb);
    throw;
  }
}

}  // namespace furnace
