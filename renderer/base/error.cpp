#include "renderer/base/error.hpp"

#include <utility>

namespace furnace {

void fail(ErrorCode code, std::string message, std::string pointer, std::string detail) {
  throw Error{code, std::move(message), std::move(pointer), std::move(detail), {}, {}};
}

std::string_view error_code_name(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidRequest:
      return "invalid-request";
    case ErrorCode::kNotFound:
      return "not-found";
    case ErrorCode::kMethodNotAllowed:
      return "method-not-allowed";
    case ErrorCode::kNotAcceptable:
      return "not-acceptable";
    case ErrorCode::kTooLarge:
      return "too-large";
    case ErrorCode::kUnsupportedMedia:
      return "unsupported-media-type";
    case ErrorCode::kUnprocessable:
      return "unprocessable";
    case ErrorCode::kOverloaded:
      return "overloaded";
    case ErrorCode::kInternal:
      return "internal";
    case ErrorCode::kBadGateway:
      return "bad-gateway";
    case ErrorCode::kGpuUnavailable:
      return "gpu-unavailable";
    case ErrorCode::kDeadlineExceeded:
      return "deadline-exceeded";
    case ErrorCode::kStorage:
      return "storage";
  }
  return "internal";
}

}  // namespace furnace
