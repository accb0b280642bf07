#include "server/dispatcher.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "renderer/base/deadline.hpp"
#include "renderer/base/log.hpp"
#include "api/document.hpp"
#include "api/problem.hpp"
#include "server/byte_range.hpp"
#include "server/gate.hpp"
#include "server/metrics.hpp"

namespace furnace {
namespace {

constexpr std::string_view kNoRoute = "none";        // metrics label of what no route took
constexpr std::string_view kRetryBusySeconds = "1";  // a seat is free again within a picture's time
constexpr std::string_view kRetryDownSeconds = "5";
constexpr std::int64_t kAnyLength = 1ll << 60;  // of a body that is not read

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

bool takes(const Route& route, std::string_view path) {
  if (!route.path.ends_with("/*")) return route.path == path;
  const std::string_view folder = route.path.substr(0, route.path.size() - 1);
  return path.starts_with(folder) && path.size() > folder.size();
}

// Statuses of the protocol itself that an ErrorCode stands for.
std::optional<ErrorCode> code_of(int status) {
  switch (status) {
    case 400:
      return ErrorCode::kInvalidRequest;
    case 413:
      return ErrorCode::kTooLarge;
    case 415:
      return ErrorCode::kUnsupportedMedia;
    case 429:
      return ErrorCode::kOverloaded;
    default:
      return std::nullopt;
  }
}

// Phrases of RFC 9110 for the others.
std::string_view phrase(int status) {
  switch (status) {
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 408:
      return "Request Timeout";
    case 414:
      return "URI Too Long";
    case 417:
      return "Expectation Failed";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 501:
      return "Not Implemented";
    default:
      return "Refused";
  }
}

log::Origin origin_of(const Request& request) {
  return {request.id, request.trace.trace_id, request.trace.span_id};
}

// What a key opened is for its holder, not for a proxy that asks nobody for keys.
void keep_from_shared_caches(Reply& reply) {
  constexpr std::string_view kPublic = "public,";
  for (auto& [name, value] : reply.headers)
    if (name == "Cache-Control" && value.starts_with(kPublic)) value.replace(0, kPublic.size(), "private,");
}

void log_error(const Error& error, int status) {
  const auto write = status >= 500 && status != 504 ? log::error : log::info;
  write("request.failed", {{"code", error_code_name(error.code)},
                           {"message", error.message},
                           {"pointer", error.pointer},
                           {"detail", error.detail},
                           {"problems", error.problems.size()},
                           {"context", fmt::format("{}", fmt::join(error.context, " < "))}});
}

Error internal_error(std::string detail) {
  return {ErrorCode::kInternal,
          "The server made a mistake; its log has the details under this request's id.",
          {},
          std::move(detail),
          {},
          {}};
}

}  // namespace

Dispatcher::Dispatcher(std::vector<Route> routes, Metrics& metrics, Gate* gate)
    : routes_(std::move(routes)), metrics_(metrics), gate_(gate) {}

Reply Dispatcher::handle(Request request) const {
  const log::RequestScope scope(origin_of(request));
  const auto start = Clock::now();
  metrics_.requests_in_flight.Increment();
  std::string_view route = kNoRoute;

  Entry entry;
  Reply reply = answer(request, route, entry);
  if (gate_ != nullptr) gate_->leave(entry, reply.status, reply.renders);
  for (const auto& [name, value] : entry.headers) reply.with(name, value);
  if (!entry.client.name.empty()) keep_from_shared_caches(reply);
  serve_range(request, reply);
  add_common_headers(reply, request);

  const double seconds = seconds_since(start);
  metrics_.requests_in_flight.Decrement();
  metrics_.observe_request(route, reply.status, seconds);
  if (!entry.client.name.empty()) metrics_.observe_client(entry.client.name, reply.status);
  log::info("request.done", {{"method", request.method},
                             {"path", request.path},
                             {"client", entry.client.name},
                             {"parent_span_id", request.trace.parent_id},
                             {"status", reply.status},
                             {"ms", seconds * 1e3},
                             {"bytes_in", request.body.size()},
                             {"bytes_out", reply.part   ? reply.part->size()
                                           : reply.file ? reply.file->bytes
                                                        : std::int64_t(reply.body.size())}});
  return reply;
}

// The one catch of the HTTP door.
Reply Dispatcher::answer(Request& request, std::string_view& route, Entry& entry) const {
  try {
    if (request.method == "OPTIONS") {
      const std::string allowed = allowed_methods(request.path);
      if (!allowed.empty()) {
        Reply reply = Reply{204, {}, {}, {}}.with("Allow", allowed);
        if (gate_ != nullptr) gate_->cors().add_preflight(reply, request, allowed);
        return reply;
      }
    }
    const Route& found = find(request);
    route = found.path;
    if (gate_ != nullptr) entry = gate_->enter({found.scopes, found.draws}, request);
    if (entry.refused != 0) return refused(request, {entry.refused, entry.detail});
    request.client = entry.client;
    return found.handler(request);
  } catch (const Error& error) {
    return problem(request, error);
  } catch (const std::exception& stray) {
    return problem(request, internal_error(stray.what()));
  }
}

Incoming Dispatcher::receive(Request& head) const {
  const Route* route = route_of(head);
  if (route == nullptr || !route->receive) return {};
  const Incoming unwanted{nullptr, kAnyLength, true};
  if (gate_ != nullptr) {
    const Entry entry = gate_->look({route->scopes, route->draws}, head);
    if (entry.refused != 0) return unwanted;
    head.client = entry.client;
  }
  try {
    return route->receive(head);
  } catch (const Error&) {
  } catch (const std::exception&) {
  }
  return unwanted;
}

const Route* Dispatcher::route_of(const Request& request) const {
  const std::string_view method = request.method == "HEAD" ? std::string_view("GET") : request.method;
  const auto found = std::ranges::find_if(
      routes_, [&](const Route& route) { return route.method == method && takes(route, request.path); });
  return found == routes_.end() ? nullptr : &*found;
}

const Route& Dispatcher::find(const Request& request) const {
  if (const Route* route = route_of(request)) return *route;
  if (const std::string allowed = allowed_methods(request.path); !allowed.empty()) {
    fail(ErrorCode::kMethodNotAllowed, fmt::format("{} takes {}.", request.path, allowed));
  }
  fail(ErrorCode::kNotFound, "There is nothing at this path; /openapi.json lists what there is.");
}

std::string Dispatcher::allowed_methods(std::string_view path) const {
  std::string allowed;
  for (const Route& route : routes_) {
    if (!takes(route, path)) continue;
    allowed += fmt::format("{}{}", route.method, route.method == "GET" ? ", HEAD, " : ", ");
  }
  return allowed.empty() ? allowed : allowed + "OPTIONS";
}

Reply Dispatcher::problem(const Request& request, const Error& error) const {
  const int status = api::http_status(error.code);
  log_error(error, status);
  metrics_.observe_error(error_code_name(error.code));
  Reply reply{status,
              std::string(api::kProblemMediaType),
              api::problem_json(error, request.id, request.trace.trace_id),
              {}};
  if (error.code == ErrorCode::kMethodNotAllowed) reply.with("Allow", allowed_methods(request.path));
  if (error.code == ErrorCode::kOverloaded) reply.with("Retry-After", std::string(kRetryBusySeconds));
  if (error.code == ErrorCode::kGpuUnavailable) reply.with("Retry-After", std::string(kRetryDownSeconds));
  if (error.code == ErrorCode::kNotAcceptable) reply.with("Vary", "Accept");
  return reply;
}

// On every reply: nothing of ours is a document that may run or fetch anything.
void Dispatcher::add_common_headers(Reply& reply, const Request& request) const {
  if (!request.id.empty()) reply.with("X-Request-Id", request.id);
  if (!request.trace.trace_id.empty()) reply.with("traceresponse", request.trace.text());
  reply.with("X-Content-Type-Options", "nosniff");
  reply.with("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
  const auto is_policy = [](const auto& header) { return header.first == "Cross-Origin-Resource-Policy"; };
  if (std::ranges::none_of(reply.headers, is_policy)) reply.with("Cross-Origin-Resource-Policy", "same-site");
  if (reply.status >= 400) reply.with("Cache-Control", "no-store");
  if (gate_ != nullptr) gate_->cors().add(reply, request);
}

Reply Dispatcher::refused(const Request& request, const Refusal& refusal) const {
  log::info("request.refused", {{"status", refusal.status}, {"detail", refusal.detail}});
  return {refusal.status,
          std::string(api::kProblemMediaType),
          api::blank_problem_json(refusal.status, phrase(refusal.status), refusal.detail, request.id,
                                  request.trace.trace_id),
          {}};
}

Reply Dispatcher::refuse(const Request& request, const Refusal& refusal) const {
  const log::RequestScope scope(origin_of(request));
  metrics_.observe_request(kNoRoute, refusal.status, 0);
  Reply reply;
  if (refusal.error) {
    reply = problem(request, *refusal.error);
  } else if (const auto code = code_of(refusal.status)) {
    reply = problem(request, {*code, refusal.detail, {}, {}, {}, {}});
  } else {
    reply = refused(request, refusal);
  }
  add_common_headers(reply, request);
  return reply;
}

Reply Dispatcher::without_request(ErrorCode code, std::string message) const {
  const Request nobody;
  Reply reply = problem(nobody, {code, std::move(message), {}, {}, {}, {}});
  add_common_headers(reply, nobody);
  return reply;
}

Reply Dispatcher::overloaded() const {
  return without_request(ErrorCode::kOverloaded,
                         "The server has too many connections; try again in a moment.");
}

Reply Dispatcher::needs_tls() const {
  return without_request(ErrorCode::kInvalidRequest,
                         "This port speaks HTTPS; ask again with https:// in the URL.");
}

}  // namespace furnace
