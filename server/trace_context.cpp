#include "server/trace_context.hpp"

#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "server/crypto.hpp"
#include "server/key_lines.hpp"

namespace furnace {
namespace {

constexpr int kTraceBytes = 16, kSpanBytes = 8;

bool is_hex(std::string_view digits) {
  return digits.find_first_not_of("0123456789abcdef") == digits.npos;
}

bool is_id(std::string_view digits) {
  return is_hex(digits) && digits.find_first_not_of('0') != digits.npos;
}

std::string new_id(int bytes) {
  std::string id;
  do {
    id = hex_of_bytes(random_bytes(bytes));
  } while (!is_id(id));
  return id;
}

// W3C Trace Context, 3.2: VERSION-TRACE-PARENT-FLAGS. Version 00 ends there; a later one may go on behind another hyphen.
std::optional<TraceContext> parse(std::string_view field) {
  constexpr std::size_t kSize = 55;
  if (field.size() < kSize || field[2] != '-' || field[35] != '-' || field[52] != '-') return std::nullopt;
  const std::string_view version = field.substr(0, 2), trace = field.substr(3, 32),
                         parent = field.substr(36, 16), flags = field.substr(53, 2);
  if (!is_hex(version) || version == "ff" || !is_id(trace) || !is_id(parent) || !is_hex(flags))
    return std::nullopt;
  if (field.size() > kSize && (version == "00" || field[kSize] != '-')) return std::nullopt;
  TraceContext context{std::string(trace), {}, std::string(parent), 0};
  std::from_chars(flags.data(), flags.data() + flags.size(), context.flags, 16);
  context.flags &= TraceContext::kSampled | TraceContext::kRandom;  // 3.2.2.5: others are not passed on
  return context;
}

}  // namespace

std::string TraceContext::text() const {
  return fmt::format("00-{}-{}-{:02x}", trace_id, span_id, flags);
}

TraceContext trace_of(std::string_view traceparent) {
  TraceContext context =
      parse(traceparent).value_or(TraceContext{new_id(kTraceBytes), {}, {}, TraceContext::kRandom});
  context.span_id = new_id(kSpanBytes);
  return context;
}

}  // namespace furnace
