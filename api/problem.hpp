// Error -> RFC 9457 problem document, and the one table of HTTP statuses.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/error.hpp"

namespace furnace::api {

inline constexpr std::string_view kProblemMediaType = "application/problem+json";

int http_status(ErrorCode code);
std::string_view problem_title(
    ErrorCode code);  // the same for every error of one code (RFC 9457 section 3.1.3)

// {type, title, status, detail, instance, traceId, pointer, errors}: `instance` is the request id, `traceId` that of W3C Trace
// Context, both left out when empty; `pointer` and `errors` only when there are any. Error::detail and Error::context are for
// the log and never written here.
std::string problem_json(const Error& error, std::string_view request_id, std::string_view trace_id = {});

// RFC 9457 section 4.2.1: "about:blank" says no more than the status does. For statuses that no ErrorCode stands for.
std::string blank_problem_json(int status, std::string_view title, std::string_view detail,
                               std::string_view request_id, std::string_view trace_id = {});

// Who fixes a document fixes it from the first problems on; more would only make answers long.
inline constexpr std::size_t kMaxProblems = 100;

// Fails with all `problems` in one Error whose message tells their number and the first; returns when there
// are none.
void fail_if_any(std::vector<Problem> problems, ErrorCode code = ErrorCode::kUnprocessable);

}  // namespace furnace::api
