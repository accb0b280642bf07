#include "server/url_signature.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "api/problem.hpp"
#include "server/crypto.hpp"
#include "server/key_lines.hpp"
#include "server/url_query.hpp"

namespace furnace {
namespace {

constexpr std::string_view kKeyId = "kid", kExpires = "exp", kSignature = "sig";
constexpr std::string_view kNotSigned =
    "This server draws signed URLs only: kid, exp and sig are needed, each once.";
constexpr std::string_view kWrong = "The signature does not fit this URL.";

// None unless the name is there exactly once: of two, signer and reader might each mean another.
const std::string* only_value(std::span<const api::QueryPair> pairs, std::string_view name) {
  if (std::ranges::count(pairs, name, &api::QueryPair::name) != 1) return nullptr;
  return &std::ranges::find(pairs, name, &api::QueryPair::name)->value;
}

std::string signature_of(std::span<const api::QueryPair> pairs, std::string_view secret) {
  return base64url(hmac_sha256(secret, canonical_text(pairs)));
}

}  // namespace

std::string canonical_text(std::span<const api::QueryPair> pairs) {
  std::vector<api::QueryPair> others;
  std::ranges::copy_if(pairs, std::back_inserter(others),
                       [](const api::QueryPair& pair) { return pair.name != kSignature; });
  return "GET\n/v1/render\n" + canonical_query(others);
}

std::string signed_url(std::vector<api::QueryPair> pairs, const UrlKey& key, std::int64_t expires_s) {
  for (const api::QueryPair& pair : pairs)
    if (pair.name == kKeyId || pair.name == kExpires || pair.name == kSignature)
      fail(ErrorCode::kUnprocessable, fmt::format("{} is part of the signature", pair.name));
  pairs.push_back({std::string(kKeyId), key.id});
  pairs.push_back({std::string(kExpires), std::to_string(expires_s)});
  const std::string signature = signature_of(pairs, key.secret);
  return fmt::format("/v1/render?{}&{}={}", canonical_query(pairs), kSignature, signature);
}

std::vector<UrlKey> parse_url_keys(std::string_view text) {
  constexpr std::size_t kLeastSecret = 16, kMostSecret = 256;
  std::vector<UrlKey> keys;
  std::set<std::string, std::less<>> seen;
  std::vector<Problem> problems;
  for (const KeyLine& line : key_lines(text)) {
    const auto refuse = [&](std::string message) { problems.push_back({line.place, std::move(message)}); };
    if (line.fields.size() != 2) {
      refuse("is not of the form KEYID:HEX-SECRET");
      continue;
    }
    auto secret = bytes_of_hex(line.fields[1]);
    if (!is_key_name(line.fields[0]))
      refuse(std::string(kKeyNameForm));
    else if (!seen.insert(std::string(line.fields[0])).second)
      refuse("has the key id of another line");
    else if (!secret || secret->size() < kLeastSecret || secret->size() > kMostSecret)
      refuse("its secret is not 32 to 512 hexadecimal digits");
    else
      keys.push_back({std::string(line.fields[0]), *std::move(secret)});
  }
  if (problems.empty() && keys.empty()) problems.push_back({"line 1", "there is no key in the file"});
  api::fail_if_any(std::move(problems));
  return keys;
}

UrlSignatures::UrlSignatures(const std::vector<UrlKey>& keys) {
  for (const UrlKey& key : keys) secrets_.emplace(key.id, key.secret);
}

std::string_view UrlSignatures::fault(std::string_view query, std::int64_t now_s) const {
  const auto pairs = parse_query(query);
  if (!pairs) return kNotSigned;
  const std::string* id = only_value(*pairs, kKeyId);
  const std::string* expires = only_value(*pairs, kExpires);
  const std::string* signature = only_value(*pairs, kSignature);
  if (id == nullptr || expires == nullptr || signature == nullptr) return kNotSigned;
  const auto found = secrets_.find(*id);
  if (found == secrets_.end()) return kWrong;
  if (!equal_in_constant_time(signature_of(*pairs, found->second), *signature)) return kWrong;
  std::int64_t end_s = 0;
  const char* const last = expires->data() + expires->size();
  const auto [stop, bad] = std::from_chars(expires->data(), last, end_s);
  if (bad != std::errc{} || stop != last) return "exp is not a number of seconds.";
  if (end_s <= now_s) return "This URL has expired.";
  if (end_s - now_s > kMaxUrlLifeS) return "exp is more than a year ahead.";
  return {};
}

}  // namespace furnace
