// Signed image URLs: who has a secret of the operator's says which pictures others may have drawn, and until when.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/image_query.hpp"

namespace furnace {

inline constexpr std::int64_t kMaxUrlLifeS = 366ll * 24 * 3600;

// What is signed: "GET\n/v1/render\n" and canonical_query of the pairs without "sig", in the order of the URL.
std::string canonical_text(std::span<const api::QueryPair> pairs);

struct UrlKey {
  std::string id;
  std::string secret;  // bytes, not their hexadecimal digits
};

// "/v1/render?PAIRS&kid=ID&exp=EXPIRES_S&sig=SIGNATURE". Errors: kUnprocessable when the pairs hold one of these three.
std::string signed_url(std::vector<api::QueryPair> pairs, const UrlKey& key, std::int64_t expires_s);

// Lines KEYID:HEX-SECRET, "#" comments; several keys, so that a new one can be in use before the old one goes. A secret has
// 16 to 256 bytes. Errors: kUnprocessable with all problems, which never quote a secret.
std::vector<UrlKey> parse_url_keys(std::string_view text);

// Threads: immutable. Owns: the secrets.
class UrlSignatures {
 public:
  explicit UrlSignatures(const std::vector<UrlKey>& keys);

  // What is wrong with the signature of `query`, a URL's query as sent, at `now_s` of Unix time; "" when it holds. Nothing but
  // the query's pairs is looked at before. A URL must end within kMaxUrlLifeS.
  std::string_view fault(std::string_view query, std::int64_t now_s) const;

 private:
  std::map<std::string, std::string, std::less<>> secrets_;
};

}  // namespace furnace
