#include "server/content_range.hpp"

#include <charconv>

namespace furnace {
namespace {

// Digits alone, up to `end`, which is taken off with them.
std::optional<std::int64_t> take_number(std::string_view& text, std::string_view end) {
  std::int64_t number = 0;
  const auto [stop, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{} || number < 0 || text.front() == '-') return std::nullopt;
  text.remove_prefix(std::size_t(stop - text.data()));
  if (!text.starts_with(end) || (end.empty() && !text.empty())) return std::nullopt;
  text.remove_prefix(end.size());
  return number;
}

}  // namespace

std::optional<ContentRange> parse_content_range(std::string_view field) {
  constexpr std::string_view kUnit = "bytes ", kNone = "*/";
  if (!field.starts_with(kUnit)) return std::nullopt;
  field.remove_prefix(kUnit.size());
  if (field.starts_with(kNone)) {
    field.remove_prefix(kNone.size());
    const auto total = take_number(field, {});
    return total ? std::optional(ContentRange{0, 0, *total}) : std::nullopt;
  }
  const auto first = take_number(field, "-");
  const auto last = first ? take_number(field, "/") : std::nullopt;
  const auto total = last ? take_number(field, {}) : std::nullopt;
  if (!total || *first > *last || *last >= *total) return std::nullopt;
  return ContentRange{*first, *last + 1, *total};
}

}  // namespace furnace
