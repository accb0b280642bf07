// Content-Range of an upload (RFC 9110 section 14.4): which bytes of the whole a body is.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace furnace {

// "bytes 0-99/1000"; or "bytes */1000", of an empty body that only asks how much is there.
struct ContentRange {
  std::int64_t first = 0;
  std::int64_t end = 0;  // behind the last; `first` when it only asks
  std::int64_t total = 0;

  bool only_asks() const { return end == first; }
};

// None for anything else, a total that is not stated among it.
std::optional<ContentRange> parse_content_range(std::string_view field);

}  // namespace furnace
