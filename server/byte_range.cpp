#include "server/byte_range.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "api/problem.hpp"

namespace furnace {
namespace {

// Digits alone; none for "" too. Larger than any file: as large as may be.
std::optional<std::int64_t> number_of(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != text.npos) return std::nullopt;
  std::int64_t number = 0;
  const auto fault = std::from_chars(text.data(), text.data() + text.size(), number).ec;
  return fault == std::errc{} ? number : INT64_MAX;
}

constexpr const char* kAcceptRanges = "Accept-Ranges";

// "" without one, or with a weak one.
std::string_view strong_tag(const Reply& reply) {
  const auto tag = std::ranges::find(reply.headers, "ETag", [](const auto& header) { return header.first; });
  return tag == reply.headers.end() || tag->second.starts_with("W/") ? std::string_view() : tag->second;
}

}  // namespace

RangeWish wished_range(std::string_view field, std::int64_t total) {
  constexpr std::string_view kUnit = "bytes=";
  if (!field.starts_with(kUnit) || field.find(',') != field.npos) return {};
  field.remove_prefix(kUnit.size());
  const std::size_t dash = field.find('-');
  if (dash == field.npos) return {};
  const std::string_view from = field.substr(0, dash), to = field.substr(dash + 1);
  const auto first = number_of(from), last = number_of(to);
  if ((!first && !from.empty()) || (!last && !to.empty()) || (!first && !last)) return {};
  if (first && last && *first > *last) return {};
  constexpr auto kNone = RangeWish::Kind::kNone, kPart = RangeWish::Kind::kPart;
  if (!first)  // the last so many
    return *last == 0 ? RangeWish{kNone}
                      : RangeWish{kPart, {std::max<std::int64_t>(total - *last, 0), total}};
  if (*first >= total) return {kNone};
  return {kPart, {*first, last ? std::min(*last, total - 1) + 1 : total}};
}

bool says_ranges(const Reply& reply) {
  return std::ranges::any_of(reply.headers, [](const auto& header) { return header.first == kAcceptRanges; });
}

void serve_range(const Request& request, Reply& reply) {
  const bool is_head = request.method == "HEAD";
  if ((!is_head && request.method != "GET") || reply.status != 200 || reply.stream) return;
  const std::string_view tag = strong_tag(reply);
  const std::int64_t total = reply.file ? reply.file->bytes : std::int64_t(reply.body.size());
  if (tag.empty() || total == 0) return;
  const std::string_view condition = request.header("If-Range");
  const bool is_same = condition.empty() || condition == tag;
  const RangeWish wish = is_same && !is_head ? wished_range(request.header("Range"), total) : RangeWish{};
  reply.with(kAcceptRanges, "bytes");
  if (wish.kind == RangeWish::Kind::kWhole) return;
  if (wish.kind == RangeWish::Kind::kNone) {
    const std::string detail = fmt::format("There are {} bytes.", total);
    reply = Reply{416,
                  std::string(api::kProblemMediaType),
                  api::blank_problem_json(416, "Range Not Satisfiable", detail, request.id),
                  {}};
    reply.with("Content-Range", fmt::format("bytes */{}", total));
    return;
  }
  reply.status = 206;
  reply.part = wish.part;
  reply.with("Content-Range", fmt::format("bytes {}-{}/{}", wish.part.first, wish.part.end - 1, total));
}

}  // namespace furnace
