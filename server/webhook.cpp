#include "server/webhook.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "api/problem.hpp"
#include "server/crypto.hpp"
#include "server/key_lines.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

constexpr std::string_view kSecretPrefix = "whsec_";
constexpr std::size_t kMostKeys = 8, kLeastSecret = 24, kMostSecret = 64;

// RFC 4648 section 4, padded.
std::string base64(std::string_view bytes) {
  std::string text = base64url(bytes);
  std::ranges::replace(text, '-', '+');
  std::ranges::replace(text, '_', '/');
  return text.append((4 - text.size() % 4) % 4, '=');
}

std::optional<std::string> base64_decoded(std::string text) {
  if (text.find_first_of("-_") != std::string::npos) return std::nullopt;
  std::ranges::replace(text, '+', '-');
  std::ranges::replace(text, '/', '_');
  return base64url_decoded(text);
}

bool is_worth_another_attempt(const OutboundAnswer& answer) {
  switch (answer.fault) {
    case OutboundFault::kUnreachable:
    case OutboundFault::kTimeout:
    case OutboundFault::kBadAnswer:
      return true;
    case OutboundFault::kRefused:
    case OutboundFault::kCancelled:
      return false;
    case OutboundFault::kNone:
    case OutboundFault::kTooLarge:
      break;
  }
  return answer.status == 408 || answer.status == 429 || answer.status >= 500;
}

}  // namespace

std::vector<WebhookKey> parse_webhook_keys(std::string_view text) {
  std::vector<WebhookKey> keys;
  std::set<std::string, std::less<>> seen;
  std::vector<Problem> problems;
  for (const KeyLine& line : key_lines(text)) {
    const auto refuse = [&](std::string message) { problems.push_back({line.place, std::move(message)}); };
    if (line.fields.size() != 2 || !line.fields[1].starts_with(kSecretPrefix)) {
      refuse("is not of the form NAME:whsec_BASE64");
      continue;
    }
    auto secret = base64_decoded(std::string(line.fields[1].substr(kSecretPrefix.size())));
    if (!is_key_name(line.fields[0]))
      refuse(std::string(kKeyNameForm));
    else if (!seen.insert(std::string(line.fields[0])).second)
      refuse("has the name of another line");
    else if (!secret || secret->size() < kLeastSecret || secret->size() > kMostSecret)
      refuse(fmt::format("its secret is not the base64 of {} to {} bytes", kLeastSecret, kMostSecret));
    else if (keys.size() == kMostKeys)
      refuse(fmt::format("is more than {} keys", kMostKeys));
    else
      keys.push_back({std::string(line.fields[0]), *std::move(secret)});
  }
  if (problems.empty() && keys.empty()) problems.push_back({"line 1", "there is no key in the file"});
  api::fail_if_any(std::move(problems));
  return keys;
}

std::string webhook_secret_text(std::string_view secret) {
  return std::string(kSecretPrefix) + base64(secret);
}

std::string webhook_signature(std::span<const WebhookKey> keys, std::string_view id, std::int64_t timestamp_s,
                              std::string_view body) {
  const std::string text = fmt::format("{}.{}.{}", id, timestamp_s, body);
  std::string signatures;
  for (const WebhookKey& key : keys)
    signatures +=
        fmt::format("{}v1,{}", signatures.empty() ? "" : " ", base64(hmac_sha256(key.secret, text)));
  return signatures;
}

std::string webhook_id(std::string_view job_id) {
  return fmt::format("msg_{}", job_id);
}

Verdict judge(const OutboundAnswer& answer, const RetryPolicy& policy, int attempts, std::int64_t due_ms,
              std::int64_t now_ms, double chance) {
  using Kind = Verdict::Kind;
  const bool has_answer = answer.fault == OutboundFault::kNone || answer.fault == OutboundFault::kTooLarge;
  if (has_answer && answer.status >= 200 && answer.status < 300) return {Kind::kDelivered};
  if (!is_worth_another_attempt(answer) || attempts >= policy.max_attempts) return {Kind::kFailed};
  constexpr double kGrowth = 3, kChanceShare = 0.2;
  double pause_ms = double(policy.first_pause_ms);
  for (int i = 1; i < attempts && pause_ms < double(policy.most_pause_ms); ++i) pause_ms *= kGrowth;
  pause_ms = std::min(pause_ms * (1 + kChanceShare * chance), double(policy.most_pause_ms));
  const std::int64_t asked_ms = std::min(answer.retry_after_s, policy.most_pause_ms / 1000) * 1000;
  const std::int64_t next_ms = now_ms + std::max(std::int64_t(pause_ms), asked_ms);
  if (next_ms - due_ms > policy.max_age_ms) return {Kind::kFailed};
  return {Kind::kAgain, next_ms};
}

}  // namespace furnace
