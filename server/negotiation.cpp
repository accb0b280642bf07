#include "server/negotiation.hpp"
#include "server/field_text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <vector>

namespace furnace {
namespace {

// Splits at `separator`, except within quoted strings; items are trimmed.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> items;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i == text.size() || (!quoted && text[i] == separator)) {
      items.push_back(trimmed(text.substr(begin, i - begin)));
      begin = i + 1;
    } else if (text[i] == '"') {
      quoted = !quoted;
    } else if (quoted && text[i] == '\\' && i + 1 < text.size()) {
      ++i;
    }
  }
  return items;
}

std::string unquoted(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::string(text);
  std::string out;
  for (std::size_t i = 1; i + 1 < text.size(); ++i) {
    if (text[i] == '\\' && i + 2 < text.size()) ++i;
    out += text[i];
  }
  return out;
}

// 3: the type itself, 2: its major type, 1: anything, 0: does not match.
int specificity(std::string_view range, std::string_view media_type) {
  if (range == media_type) return 3;
  if (range == "*/*") return 1;
  const std::size_t slash = media_type.find('/');
  const bool same_major = range.size() == slash + 2 && range.substr(0, slash) == media_type.substr(0, slash);
  return same_major && range.ends_with("/*") ? 2 : 0;
}

double quality_of(const std::vector<std::string_view>& range_and_parameters) {
  for (std::size_t i = 1; i < range_and_parameters.size(); ++i) {
    const std::string parameter = lower(range_and_parameters[i]);
    if (!parameter.starts_with("q=")) continue;
    double quality = 0;  // what is not a number is a refusal
    std::from_chars(parameter.data() + 2, parameter.data() + parameter.size(), quality);
    return std::clamp(quality, 0.0, 1.0);
  }
  return 1;
}

}  // namespace

std::string media_type_essence(std::string_view content_type) {
  return lower(trimmed(content_type.substr(0, content_type.find(';'))));
}

std::string media_type_parameter(std::string_view content_type, std::string_view name) {
  const auto items = split(content_type, ';');
  for (std::size_t i = 1; i < items.size(); ++i) {
    const std::size_t equals = items[i].find('=');
    if (equals == std::string_view::npos || lower(trimmed(items[i].substr(0, equals))) != name) continue;
    return unquoted(trimmed(items[i].substr(equals + 1)));
  }
  return {};
}

double accept_quality(std::string_view accept, std::string_view media_type) {
  if (trimmed(accept).empty()) return 1;
  int best = 0;
  double quality = 0;
  for (const std::string_view item : split(accept, ',')) {
    const auto range = split(item, ';');
    const int match = specificity(lower(range.front()), media_type);
    if (match > best) {
      best = match;
      quality = quality_of(range);
    }
  }
  return quality;
}

bool etag_matches(std::string_view if_none_match, std::string_view etag) {
  for (std::string_view item : split(if_none_match, ',')) {
    if (item.starts_with("W/")) item.remove_prefix(2);
    if (item.size() == etag.size() + 2 && item.front() == '"' && item.back() == '"' &&
        item.substr(1, etag.size()) == etag) {
      return true;
    }
  }
  return false;
}

}  // namespace furnace
