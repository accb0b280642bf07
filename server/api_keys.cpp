#include "server/api_keys.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "api/problem.hpp"
#include "server/hash_text.hpp"
#include "server/key_lines.hpp"
#include "server/settings.hpp"

namespace furnace {
namespace {

constexpr int kMostPerTime = 1'000'000'000;

struct ScopeRow {
  std::string_view name;
  Scopes scope;
};
constexpr std::array kScopes = {ScopeRow{"render", scope::kRender}, ScopeRow{"assets", scope::kAssets},
                                ScopeRow{"admin", scope::kAdmin}};

std::optional<int> count_of(std::string_view text) {
  int count = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (fault != std::errc{} || end != text.data() + text.size() || count < 0 || count > kMostPerTime)
    return std::nullopt;
  return count;
}

// What is wrong with a line, or "".
std::string_view read_key(const std::vector<std::string_view>& fields, ApiKey& key) {
  if (fields.size() < 3 || fields.size() > 6)
    return "is not of the form "
           "NAME:SCOPES:HEX-SHA256-OF-KEY[:RATE-PER-MINUTE[:RENDERS-PER-DAY[:ASSET-BYTES]]]";
  if (!is_key_name(fields[0])) return kKeyNameForm;
  key.name = fields[0];
  key.scopes = scopes_of(fields[1]);
  if (key.scopes == 0) return "its scopes are not some of render, assets and admin with ',' between";
  const auto hash = parse_hash(fields[2]);
  if (!hash) return "its hash is not 64 lower-case hexadecimal digits";
  key.hash = *hash;
  const auto rate = count_of(fields.size() > 3 ? fields[3] : "0"),
             renders = count_of(fields.size() > 4 ? fields[4] : "0");
  if (!rate || !renders) return "its rate or its renders are not a whole number";
  key.rate_per_minute = *rate;
  key.renders_per_day = *renders;
  const auto bytes = parse_size(fields.size() > 5 ? fields[5] : "0");
  if (!bytes || *bytes < 0) return "its asset bytes are not a size such as 500MiB";
  key.asset_bytes = *bytes;
  return {};
}

}  // namespace

Scopes scopes_of(std::string_view list) {
  Scopes scopes = 0;
  for (bool more = true; more;) {
    const std::size_t comma = list.find(',');
    const auto row = std::ranges::find(kScopes, list.substr(0, comma), &ScopeRow::name);
    if (row == kScopes.end()) return 0;
    scopes |= row->scope;
    more = comma != std::string_view::npos;
    if (more) list.remove_prefix(comma + 1);
  }
  return scopes;
}

std::vector<ApiKey> parse_api_keys(std::string_view text) {
  std::vector<ApiKey> keys;
  std::vector<Problem> problems;
  std::set<std::string, std::less<>> names;
  std::set<ContentHash> hashes;
  for (const KeyLine& line : key_lines(text)) {
    ApiKey key;
    std::string_view fault = read_key(line.fields, key);
    if (fault.empty() && !names.insert(key.name).second) fault = "has the name of another line";
    if (fault.empty() && !hashes.insert(key.hash).second) fault = "has the key of another line";
    if (fault.empty())
      keys.push_back(std::move(key));
    else
      problems.push_back({line.place, std::string(fault)});
  }
  if (problems.empty() && keys.empty()) problems.push_back({"line 1", "there is no key in the file"});
  api::fail_if_any(std::move(problems));
  return keys;
}

}  // namespace furnace
