// sign-url and hash-key: what operators need of the files url-keys-file and api-keys-file.
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "renderer/base/content_hash.hpp"
#include "renderer/base/error.hpp"
#include "server/api_keys.hpp"
#include "server/commands/commands.hpp"
#include "server/crypto.hpp"
#include "server/key_lines.hpp"
#include "server/settings.hpp"
#include "server/url_query.hpp"
#include "server/url_signature.hpp"

namespace furnace {
namespace {

constexpr int kSecretBytes = 32;

struct SignOptions {
  std::string key_file, key_id, expires_in = "1d";
  std::vector<std::string> pairs;
};

// "90s", "15min", "12h", "30d"; none for anything else, or for more than a signature may last.
std::optional<std::int64_t> seconds_of(const std::string& text) {
  std::int64_t count = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), count);
  const std::string_view unit(end, text.data() + text.size() - end);
  const std::int64_t factor = unit == "s"     ? 1
                              : unit == "min" ? 60
                              : unit == "h"   ? 3600
                              : unit == "d"   ? 86400
                                              : 0;
  if (fault != std::errc{} || factor == 0 || count <= 0 || count > kMaxUrlLifeS / factor) return std::nullopt;
  return count * factor;
}

std::vector<api::QueryPair> pairs_of(const std::vector<std::string>& arguments) {
  std::vector<api::QueryPair> pairs;
  for (const std::string& argument : arguments) {
    if (argument.starts_with('?')) {
      const auto query = parse_query(std::string_view(argument).substr(1));
      if (!query) fail(ErrorCode::kInvalidRequest, fmt::format("{} is not a query", argument));
      pairs.insert(pairs.end(), query->begin(), query->end());
      continue;
    }
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos || argument.find('&') != std::string::npos)
      fail(ErrorCode::kInvalidRequest,
           fmt::format("{} is not KEY=VALUE; a whole query begins with ?", argument));
    pairs.push_back({argument.substr(0, equals), argument.substr(equals + 1)});
  }
  return pairs;
}

int sign_url(const SignOptions& options) {
  std::string file = options.key_file;
  if (const char* variable = std::getenv("FURNACE_URL_KEYS_FILE"); file.empty() && variable != nullptr)
    file = variable;
  if (file.empty())
    fail(ErrorCode::kInvalidRequest, "name the file of keys: --key-file, or FURNACE_URL_KEYS_FILE");
  const auto life_s = seconds_of(options.expires_in);
  if (!life_s)
    fail(ErrorCode::kInvalidRequest,
         fmt::format("'{}' is not a time such as 90s, 12h or 30d, up to a year", options.expires_in));
  const std::vector<UrlKey> keys = parse_url_keys(read_key_file(file, true));
  const auto key =
      options.key_id.empty() ? keys.begin() : std::ranges::find(keys, options.key_id, &UrlKey::id);
  if (key == keys.end()) fail(ErrorCode::kNotFound, fmt::format("the file has no key {}", options.key_id));
  fmt::print("{}\n", signed_url(pairs_of(options.pairs), *key, std::int64_t(std::time(nullptr)) + *life_s));
  return kDone;
}

struct KeyOptions {
  std::string name, scopes = "render";
  int rate = 0, renders = 0;
  std::string asset_bytes = "0";
  bool is_for_urls = false;
};

int hash_key(const KeyOptions& options) {
  if (!is_key_name(options.name)) fail(ErrorCode::kInvalidRequest, std::string(kKeyNameForm));
  if (scopes_of(options.scopes) == 0)
    fail(ErrorCode::kInvalidRequest,
         fmt::format("'{}' are not scopes: render, assets, admin", options.scopes));
  const std::string secret = random_bytes(kSecretBytes);
  if (options.is_for_urls) {
    fmt::print("{}:{}\n", options.name, hex_of_bytes(secret));
    return kDone;
  }
  const std::string key = "fk_" + base64url(secret);
  std::string line =
      fmt::format("{}:{}:{}", options.name, options.scopes, hash_bytes(std::as_bytes(std::span(key))).hex());
  const auto bytes = parse_size(options.asset_bytes);
  if (!bytes || *bytes < 0)
    fail(ErrorCode::kInvalidRequest, fmt::format("'{}' is not a size such as 500MiB", options.asset_bytes));
  if (*bytes > 0)
    line += fmt::format(":{}:{}:{}", options.rate, options.renders, options.asset_bytes);
  else if (options.renders > 0)
    line += fmt::format(":{}:{}", options.rate, options.renders);
  else if (options.rate > 0)
    line += fmt::format(":{}", options.rate);
  fmt::print("{}\n{}\n", key, line);
  return kDone;
}

}  // namespace

Command sign_url_command(CLI::App& root) {
  CLI::App* options = root.add_subcommand("sign-url", "Prints the path of a signed URL of GET /v1/render");
  const auto given = std::make_shared<SignOptions>();
  options->add_option("--key-file", given->key_file, "as url-keys-file of serve (FURNACE_URL_KEYS_FILE)");
  options->add_option("--kid", given->key_id, "which of its keys signs; the first unless given");
  options->add_option("--expires-in", given->expires_in, "how long the URL holds: 90s, 15min, 12h, 30d")
      ->capture_default_str();
  options->add_option("query", given->pairs, "KEY=VALUE as they are meant, or ?QUERY as it stands in a URL");
  return {options, [given] { return sign_url(*given); }};
}

Command hash_key_command(CLI::App& root) {
  CLI::App* options = root.add_subcommand(
      "hash-key",
      "Makes an API key: prints it, to be given away and not kept, then its line of api-keys-file");
  const auto given = std::make_shared<KeyOptions>();
  options->add_option("name", given->name, "who has it, for logs and metrics")->required();
  options->add_option("--scopes", given->scopes, "of render, assets, admin; separated by ','")
      ->capture_default_str();
  options->add_option("--rate", given->rate, "requests a minute; 0: any")->check(CLI::Range(0, 1'000'000));
  options->add_option("--renders", given->renders, "renders a day; 0: any")
      ->check(CLI::Range(0, 100'000'000));
  options
      ->add_option("--asset-bytes", given->asset_bytes,
                   "what its uploads may have together: 500MiB, 2GiB; 0: any")
      ->capture_default_str();
  options->add_flag("--url", given->is_for_urls,
                    "a line of url-keys-file instead, which is the secret itself");
  return {options, [given] { return hash_key(*given); }};
}

}  // namespace furnace
