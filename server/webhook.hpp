// What webhooks are made of, by the convention of Standard Webhooks 1.0: keys, signature, and when to try again. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/outbound_client.hpp"

namespace furnace {

struct WebhookKey {
  std::string name;
  std::string secret;  // bytes, not their base64
};

// Lines NAME:whsec_BASE64, "#" comments; at most 8. All sign, so that receivers may change from one to the next. A secret has
// 24 to 64 bytes. Errors: kUnprocessable with all problems, which never quote a secret.
std::vector<WebhookKey> parse_webhook_keys(std::string_view text);
std::string webhook_secret_text(std::string_view secret);  // "whsec_BASE64"

// The value of webhook-signature: "v1,BASE64 v1,BASE64", in the order of the keys.
std::string webhook_signature(std::span<const WebhookKey> keys, std::string_view id, std::int64_t timestamp_s,
                              std::string_view body);

// The same for all attempts at one job's webhook, so that a receiver tells a repetition.
std::string webhook_id(std::string_view job_id);

struct RetryPolicy {
  int max_attempts = 10;
  std::int64_t first_pause_ms = 5'000;        // then three times as long each time
  std::int64_t most_pause_ms = 6 * 3600'000;  // also of what Retry-After asks for
  std::int64_t max_age_ms = 24ll * 3600'000;  // of the news; older is not told again
};

struct Verdict {
  enum class Kind { kDelivered, kAgain, kFailed } kind = Kind::kFailed;
  std::int64_t next_ms = 0;  // of kAgain, since the epoch
};

// What an attempt came to: 2xx is delivered; an endpoint that cannot be reached or is late, 408, 429 and 5xx are tried again;
// all else has failed. `attempts` counts this one. Pauses are up to a fifth longer by chance, in [0, 1), so that what failed
// together does not come back together.
Verdict judge(const OutboundAnswer& answer, const RetryPolicy& policy, int attempts, std::int64_t due_ms,
              std::int64_t now_ms, double chance);

}  // namespace furnace
