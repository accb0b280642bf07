#include "server/gate.hpp"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "renderer/base/content_hash.hpp"
#include "server/api_keys.hpp"
#include "server/key_lines.hpp"
#include "server/rate_limit.hpp"
#include "server/url_signature.hpp"

namespace furnace {
namespace {

// What one key has used. The limits are those that it was made with.
struct Account {
  explicit Account(const ApiKey& key, Clock::time_point now)
      : rate_per_minute(key.rate_per_minute),
        renders_per_day(key.renders_per_day),
        bucket(key.rate_per_minute, now),
        quota(key.renders_per_day) {}

  int rate_per_minute, renders_per_day;
  TokenBucket bucket;
  DayQuota quota;
};

using Keys = std::map<ContentHash, ApiKey>;

Keys by_hash(std::vector<ApiKey> keys) {
  Keys out;
  for (ApiKey& key : keys) out.emplace(key.hash, std::move(key));
  return out;
}

// "" when there is none.
std::string_view key_of(const Request& request) {
  constexpr std::string_view kBearer = "bearer ";  // RFC 6750; schemes compare without case
  const std::string_view field = request.header("Authorization");
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  if (field.size() > kBearer.size() && std::ranges::equal(field.substr(0, kBearer.size()), kBearer, same))
    return field.substr(kBearer.size());
  return request.header("X-Api-Key");
}

// draft-ietf-httpapi-ratelimit-headers-10.
class RateLimitFields {
 public:
  void add(std::string_view name, int quota, int window_s, const Allowance& allowance) {
    const std::string_view comma = policy_.empty() ? "" : ", ";
    policy_ += fmt::format("{}\"{}\";q={};w={}", comma, name, quota, window_s);
    state_ += fmt::format("{}\"{}\";r={};t={}", comma, name, allowance.left, allowance.reset_s);
  }
  void write(Entry& entry) const {
    if (policy_.empty()) return;
    entry.headers.emplace_back("RateLimit-Policy", policy_);
    entry.headers.emplace_back("RateLimit", state_);
  }

 private:
  std::string policy_, state_;
};

void refuse(Entry& entry, int status, std::string detail) {
  entry.refused = status;
  entry.detail = std::move(detail);
}

void refuse_for_now(Entry& entry, int retry_s, std::string detail) {
  refuse(entry, 429, std::move(detail));
  entry.headers.emplace_back("Retry-After", std::to_string(retry_s));
}

}  // namespace

struct Gate::State {
  std::mutex mutex;
  std::optional<Keys> keys;  // none: whoever comes may do all
  std::shared_ptr<const UrlSignatures> signatures;
  std::map<std::string, Account> accounts;  // by key name

  // Takes what the wish costs from the key's account.
  void charge(const ApiKey& key, const Wish& wish, const GateClock& clock, Entry& entry) {
    Account& account = accounts.try_emplace(key.name, key, clock.steady()).first->second;
    RateLimitFields fields;
    if (key.rate_per_minute > 0) {
      const Allowance allowance = account.bucket.take(clock.steady());
      fields.add("requests", key.rate_per_minute, 60, allowance);
      if (!allowance.granted)
        refuse_for_now(entry, allowance.retry_s, "This key's requests of the minute are used up.");
    }
    if (key.renders_per_day > 0 && wish.draws && entry.refused == 0) {
      const Allowance allowance = account.quota.take(clock.unix_s());
      fields.add("renders", key.renders_per_day, 86'400, allowance);
      entry.counted = allowance.granted;
      if (!allowance.granted)
        refuse_for_now(entry, allowance.retry_s, "This key's renders of the day (UTC) are used up.");
    }
    fields.write(entry);
  }
};

Gate::Gate(GateConfig config, GateClock clock)
    : config_(std::move(config)),
      clock_(std::move(clock)),
      cors_(config_.cors_origins),
      state_(std::make_unique<State>()) {
  reload();
}

Gate::~Gate() = default;

void Gate::reload() {
  std::optional<Keys> keys;
  std::shared_ptr<const UrlSignatures> signatures;
  if (!config_.api_keys_file.empty())
    keys = by_hash(parse_api_keys(read_key_file(config_.api_keys_file, false)));
  if (!config_.url_keys_file.empty())
    signatures =
        std::make_shared<const UrlSignatures>(parse_url_keys(read_key_file(config_.url_keys_file, true)));

  const std::lock_guard lock(state_->mutex);
  state_->keys = std::move(keys);
  state_->signatures = std::move(signatures);
  // Who has other limits now begins anew; who is gone is forgotten.
  std::erase_if(state_->accounts, [&](const auto& named) {
    const auto is_same = [&](const auto& entry) {
      const ApiKey& key = entry.second;
      return key.name == named.first && key.rate_per_minute == named.second.rate_per_minute &&
             key.renders_per_day == named.second.renders_per_day;
    };
    return !state_->keys || std::ranges::none_of(*state_->keys, is_same);
  });
}

Entry Gate::enter(const Wish& wish, const Request& request) {
  return check(wish, request, true);
}

Entry Gate::check(const Wish& wish, const Request& request, bool charges) {
  Entry entry;
  if (std::int64_t(request.path.size() + request.query.size()) > config_.max_url_bytes) {
    refuse(entry, 414, fmt::format("A URL's path and query may have {} bytes.", config_.max_url_bytes));
    return entry;
  }
  std::unique_lock lock(state_->mutex);
  const bool is_image = (wish.scopes & scope::kImageUrl) != 0;
  if (is_image && state_->signatures) {
    const auto signatures = state_->signatures;
    lock.unlock();
    if (const std::string_view fault = signatures->fault(request.query, clock_.unix_s()); !fault.empty())
      refuse(entry, 403, std::string(fault));
    return entry;
  }
  if (!state_->keys || wish.scopes == scope::kOpen) return entry;
  const std::string_view text = key_of(request);
  // Comparing hashes tells nothing of the keys, however long it takes.
  const auto key = state_->keys->find(hash_bytes(std::as_bytes(std::span(text))));
  if (text.empty() || key == state_->keys->end()) {
    const bool is_strange = !text.empty();
    refuse(entry, 401,
           is_strange ? "This key is not known."
                      : "A key is needed: Authorization: Bearer KEY, or X-Api-Key: KEY.");
    entry.headers.emplace_back("WWW-Authenticate", is_strange
                                                       ? "Bearer realm=\"furnace\", error=\"invalid_token\""
                                                       : "Bearer realm=\"furnace\"");
    return entry;
  }
  entry.client = {key->second.name, key->second.scopes, key->second.asset_bytes};
  const Scopes wanted = is_image ? scope::kRender : wish.scopes;
  if ((key->second.scopes & wanted) == 0) {
    refuse(entry, 403, "This key's scopes do not include this.");
    entry.headers.emplace_back("WWW-Authenticate", "Bearer realm=\"furnace\", error=\"insufficient_scope\"");
    return entry;
  }
  if (charges) state_->charge(key->second, wish, clock_, entry);
  return entry;
}

void Gate::leave(const Entry& entry, int status, int renders) {
  const int drawn = status >= 200 && status < 300 ? renders : 0;
  if (!entry.counted || drawn == 1) return;
  const std::lock_guard lock(state_->mutex);
  const auto account = state_->accounts.find(entry.client.name);
  if (account != state_->accounts.end()) account->second.quota.correct(drawn - 1);
}

}  // namespace furnace
