// The Prefer field (RFC 7240), of what we heed.
#pragma once

#include <chrono>
#include <optional>
#include <string_view>

namespace furnace {

struct Preferences {
  bool respond_async = false;
  std::optional<std::chrono::seconds> wait;  // for the answer; at most a day
};

// What is not understood is left out, as the RFC asks; of a preference that stands twice the first counts.
Preferences parse_preferences(std::string_view field);

}  // namespace furnace
