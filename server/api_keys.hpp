// The file of API keys: who they belong to, what they open, how much of it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "server/access.hpp"

namespace furnace {

struct ApiKey {
  std::string name;  // for logs and metrics
  Scopes scopes = 0;
  ContentHash hash;              // of the key's text; the key itself is not kept
  int rate_per_minute = 0;       // requests; 0: any
  int renders_per_day = 0;       // 0: any
  std::int64_t asset_bytes = 0;  // of what it has uploaded, as long as it is kept; 0: any
};

// Lines NAME:SCOPES:HEX-SHA256-OF-KEY[:RATE-PER-MINUTE[:RENDERS-PER-DAY[:ASSET-BYTES]]], "#" comments; ASSET-BYTES may be as 500MiB; scopes are render, assets and admin
// with "," between. Errors: kUnprocessable with all problems.
std::vector<ApiKey> parse_api_keys(std::string_view text);

// The scopes of such a list; 0 when it is none.
Scopes scopes_of(std::string_view list);

}  // namespace furnace
