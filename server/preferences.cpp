#include "server/preferences.hpp"

#include <algorithm>
#include <charconv>

#include "server/field_text.hpp"

namespace furnace {
namespace {

std::optional<std::chrono::seconds> seconds_of(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
  constexpr int kDay = 86'400;
  int seconds = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (fault != std::errc{} || end != text.data() + text.size() || seconds < 0) return std::nullopt;
  return std::chrono::seconds(std::min(seconds, kDay));
}

}  // namespace

Preferences parse_preferences(std::string_view field) {
  Preferences out;
  while (!field.empty()) {
    const std::size_t comma = std::min(field.find(','), field.size());
    const std::string_view preference =
        field.substr(0, std::min(field.find(';'), comma));  // its parameters aside
    field.remove_prefix(std::min(comma + 1, field.size()));
    const std::size_t equals = std::min(preference.find('='), preference.size());
    const std::string_view name = trimmed(preference.substr(0, equals));
    const std::string_view value = trimmed(preference.substr(std::min(equals + 1, preference.size())));
    if (lower(name) == "respond-async" && value.empty()) out.respond_async = true;
    if (lower(name) == "wait" && !out.wait) out.wait = seconds_of(value);
  }
  return out;
}

}  // namespace furnace
