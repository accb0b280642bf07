#include "server/framing.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <charconv>
#include <ctime>
#include <optional>
#include <random>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "server/negotiation.hpp"

namespace furnace {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 64;

// The number that all Content-Length fields agree on: "5" or "5, 5".
std::optional<std::int64_t> agreed_length(std::string_view field) {
  std::optional<std::int64_t> agreed;
  while (!field.empty()) {
    std::int64_t value = -1;
    const char* const end = field.data() + field.size();
    const auto [stop, fault] = std::from_chars(field.data(), end, value);
    if (fault != std::errc{} || value < 0 || (agreed && *agreed != value)) return std::nullopt;
    agreed = value;
    field.remove_prefix(stop - field.data());
    if (field.empty()) return agreed;
    if (!field.starts_with(", ")) return std::nullopt;
    field.remove_prefix(2);
    if (field.empty()) return std::nullopt;
  }
  return 0;
}

}  // namespace

bool has_request_body(std::string_view method) {
  return method == "POST" || method == "PUT" || method == "PATCH";
}

Framing read_framing(const Request& head, std::string_view http_version, std::int64_t max_body_bytes) {
  const std::string_view host = head.header("Host");
  if (http_version == "HTTP/1.1" && (host.empty() || host.find(',') != std::string_view::npos)) {
    return {{400, "There must be one Host field."}};
  }
  const std::string_view encoding = head.header("Content-Encoding");
  if (!encoding.empty() && media_type_essence(encoding) != "identity") {
    return {{415, "Content-Encoding is not supported: send the body as it is."}};
  }
  const std::string_view expect = head.header("Expect");
  if (!expect.empty() && media_type_essence(expect) != "100-continue")
    return {{417, "Expect may only be 100-continue."}};

  Framing framing;
  const std::string_view transfer = head.header("Transfer-Encoding");
  framing.chunked = !transfer.empty();
  if (framing.chunked && media_type_essence(transfer) != "chunked")
    return {{501, "Transfer-Encoding may only be chunked."}};
  if (framing.chunked && head.headers.contains("Content-Length")) {
    return {{400, "Content-Length and Transfer-Encoding exclude each other."}};
  }
  const auto length = agreed_length(head.header("Content-Length"));
  if (!length) return {{400, "Content-Length is not one number."}};
  if (*length > max_body_bytes) {
    return {{413, fmt::format("The body may have {} bytes; this one has {}.", max_body_bytes, *length)}};
  }
  framing.content_length = *length;
  return framing;
}

std::string http_date() {
  return fmt::format("{:%a, %d %b %Y %H:%M:%S GMT}", fmt::gmtime(std::time(nullptr)));
}

std::string raw_response(const Reply& reply) {
  std::string text = fmt::format(
      "HTTP/1.1 {} \r\nDate: {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: close\r\n",
      reply.status, http_date(), reply.media_type, reply.body.size());
  for (const auto& [name, value] : reply.headers) text += fmt::format("{}: {}\r\n", name, value);
  return text.append("\r\n").append(reply.body);
}

bool is_sane_request_id(std::string_view id) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_' || c == '.'; };
  return !id.empty() && id.size() <= kMaxRequestIdBytes && std::ranges::all_of(id, plain);
}

std::string new_request_id() {
  static const std::uint32_t process = std::random_device{}();
  static std::atomic<std::uint64_t> count = 0;
  return fmt::format("{:08x}-{:06x}", process, ++count);
}

}  // namespace furnace
