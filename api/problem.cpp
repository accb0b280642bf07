#include "api/problem.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <utility>

namespace furnace::api {
namespace {

struct StatusRow {
  int status;
  std::string_view title;
};

StatusRow status_row(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidRequest:
      return {400, "The request cannot be read"};
    case ErrorCode::kNotFound:
      return {404, "Not found"};
    case ErrorCode::kMethodNotAllowed:
      return {405, "Method not allowed"};
    case ErrorCode::kNotAcceptable:
      return {406, "No acceptable representation"};
    case ErrorCode::kTooLarge:
      return {413, "Too large"};
    case ErrorCode::kUnsupportedMedia:
      return {415, "Unsupported media type"};
    case ErrorCode::kUnprocessable:
      return {422, "The request cannot be carried out"};
    case ErrorCode::kOverloaded:
      return {429, "Too many requests"};
    case ErrorCode::kInternal:
      return {500, "Internal error"};
    case ErrorCode::kBadGateway:
      return {502, "Another server failed"};
    case ErrorCode::kGpuUnavailable:
      return {503, "Graphics unavailable"};
    case ErrorCode::kDeadlineExceeded:
      return {504, "Out of time"};
    case ErrorCode::kStorage:
      return {507, "Storage failed"};
  }
  return {500, "Internal error"};
}

}  // namespace

std::string blank_problem_json(int status, std::string_view title, std::string_view detail,
                               std::string_view request_id, std::string_view trace_id) {
  nlohmann::ordered_json problem{{"type", "about:blank"},
                                 {"title", title},
                                 {"status", status},
                                 {"detail", detail},
                                 {"instance", request_id}};
  if (!trace_id.empty()) problem["traceId"] = trace_id;
  return problem.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

int http_status(ErrorCode code) {
  return status_row(code).status;
}

std::string_view problem_title(ErrorCode code) {
  return status_row(code).title;
}

std::string problem_json(const Error& error, std::string_view request_id, std::string_view trace_id) {
  const StatusRow row = status_row(error.code);
  nlohmann::ordered_json problem;
  problem["type"] = "/problems/" + std::string(error_code_name(error.code));
  problem["title"] = row.title;
  problem["status"] = row.status;
  problem["detail"] = error.message;
  if (!request_id.empty()) problem["instance"] = request_id;
  if (!trace_id.empty()) problem["traceId"] = trace_id;
  if (!error.pointer.empty()) problem["pointer"] = error.pointer;
  for (const Problem& fault : error.problems)
    problem["errors"].push_back({{"pointer", fault.pointer}, {"detail", fault.message}});
  // Messages may quote bytes that are not UTF-8.
  return problem.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void fail_if_any(std::vector<Problem> problems, ErrorCode code) {
  if (problems.empty()) return;
  const Problem& first = problems.front();
  std::string message = (first.pointer.empty() ? "the document" : first.pointer) + ": " + first.message;
  if (problems.size() > 1) message = fmt::format("{} problems, the first at {}", problems.size(), message);
  Error error{code, std::move(message), first.pointer, {}, {}, {}};
  error.problems = std::move(problems);
  throw error;
}

}  // namespace furnace::api
