#include "server/cors.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace furnace {
namespace {

constexpr std::string_view kRequestHeaders =
    "Accept, Authorization, Content-Range, Content-Type, Furnace-Priority, Furnace-Webhook, Idempotency-Key, "
    "If-None-Match, If-Range, Prefer, Range, traceparent, tracestate, X-Api-Key, X-Request-Id";
constexpr std::string_view kReplyHeaders =
    "Accept-Ranges, Cache-Status, Content-Location, Content-Range, ETag, Furnace-Exposure-Ev, "
    "Furnace-Fingerprint, "
    "Furnace-Notes, Link, Location, Preference-Applied, RateLimit, RateLimit-Policy, Retry-After, "
    "Server-Timing, "
    "traceresponse, Upload-Offset, X-Request-Id";
constexpr std::string_view kMaxAgeS = "600";

std::vector<std::string> items_of(std::string_view list) {
  std::vector<std::string> items;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    std::string_view item = list.substr(0, end);
    list.remove_prefix(std::min(end + 1, list.size()));
    while (item.starts_with(' ')) item.remove_prefix(1);
    while (item.ends_with(' ')) item.remove_suffix(1);
    items.emplace_back(item);
  }
  return items;
}

// As browsers write it: scheme, host in lower case, a port that is not the scheme's own, no path.
bool is_origin(std::string_view text) {
  const std::size_t scheme = text.starts_with("https://") ? 8 : text.starts_with("http://") ? 7 : 0;
  if (scheme == 0 || text.size() == scheme || text.size() > 256) return false;
  return text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789.-:[]", scheme) ==
         std::string_view::npos;
}

}  // namespace

std::string Cors::fault(std::string_view list) {
  for (const std::string& item : items_of(list))
    if (item != "*" && !is_origin(item))
      return fmt::format(
          "'{}' is not an origin such as https://example.com, in lower case and without a path", item);
  return {};
}

Cors::Cors(std::string_view list) : origins_(items_of(list)) {
  all_ = std::ranges::find(origins_, "*") != origins_.end();
}

bool Cors::allows(std::string_view origin) const {
  return !origin.empty() && (all_ || std::ranges::find(origins_, origin) != origins_.end());
}

void Cors::add(Reply& reply, const Request& request) const {
  if (origins_.empty()) return;
  if (!all_) reply.with("Vary", "Origin");
  const std::string_view origin = request.header("Origin");
  if (!allows(origin)) return;
  reply.with("Access-Control-Allow-Origin", all_ ? "*" : std::string(origin))
      .with("Access-Control-Expose-Headers", std::string(kReplyHeaders));
}

void Cors::add_preflight(Reply& reply, const Request& request, const std::string& methods) const {
  if (!allows(request.header("Origin")) || request.header("Access-Control-Request-Method").empty()) return;
  reply.with("Access-Control-Allow-Methods", methods)
      .with("Access-Control-Allow-Headers", std::string(kRequestHeaders))
      .with("Access-Control-Max-Age", std::string(kMaxAgeS));
}

}  // namespace furnace
