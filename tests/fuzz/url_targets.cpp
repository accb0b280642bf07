// What stands in a URL, and what operators write into files of keys.
#include <array>
#include <vector>

#include "api/image_query.hpp"
#include "api/preset.hpp"
#include "api/problem.hpp"
#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "server/api_keys.hpp"
#include "server/image_url.hpp"
#include "server/outbound_url.hpp"
#include "server/trace_context.hpp"
#include "server/url_query.hpp"
#include "server/url_signature.hpp"
#include "server/webhook.hpp"
#include "tests/fuzz/mutators.hpp"
#include "tests/fuzz/targets.hpp"

namespace furnace::fuzz {
namespace {

constexpr std::size_t kMostUrlBytes = 8192;
constexpr std::int64_t kNow = 1'800'000'000;

// What a query is read as, it is read as again from its canonical text; a signature without the secret never holds.
void run_image_url(Input input) {
  const std::string_view query = text_of(input);
  if (const auto pairs = parse_query(query)) {
    const std::string canonical = canonical_query(*pairs);
    const auto again = parse_query(canonical);
    FURNACE_CHECK(again && canonical_query(*again) == canonical, "another canonical text");
  }
  static const UrlSignatures signatures({{"k", std::string(32, 'k')}});
  FURNACE_CHECK(!signatures.fault(query, kNow).empty(), "a signature by nobody");
  try {
    const ImageDocument asked = document_of_query(query, {}, {}, {});
    api::Document::parse(asked.text, {});
  } catch (Error& error) {
    api::point_at_query(error, {});
    api::Document::parse(api::problem_json(error, "fuzz"), {});
    throw;
  }
}

// Input: a file of API keys; behind a zero byte one of URL keys or of webhooks' secrets.
void run_keys(Input input) {
  const TextPair texts = split(input);
  try {
    for (const ApiKey& key : parse_api_keys(texts.first))
      FURNACE_CHECK(
          !key.name.empty() && key.scopes != 0 && key.rate_per_minute >= 0 && key.renders_per_day >= 0,
          "a key");
  } catch (const Error& error) {
    FURNACE_CHECK(error.code == ErrorCode::kUnprocessable, "{}", error.message);
  }
  try {
    for (const WebhookKey& key : parse_webhook_keys(texts.second))
      FURNACE_CHECK(!key.name.empty() && key.secret.size() >= 24, "a weak secret");
  } catch (const Error& error) {
    FURNACE_CHECK(error.code == ErrorCode::kUnprocessable, "{}", error.message);
  }
  for (const UrlKey& key : parse_url_keys(texts.second))
    FURNACE_CHECK(!key.id.empty() && key.secret.size() >= 16, "a weak secret");
}

void check_outbound_url(const OutboundUrl& url) {
  const auto again = parse_outbound_url(url.text);
  FURNACE_CHECK(again && again->text == url.text && again->has_origin_of(url) && again->path == url.path,
                "another reading of {}", url.text);
  static const AllowList list("example.com, *.example.org, http://127.0.0.1:9000");
  static const NetworkAddress loopback = *parse_network_address("127.0.0.1");
  const bool is_named = url.host == "example.com" || url.host.ends_with(".example.org");
  FURNACE_CHECK(!list.allows(url) || is_named || url.address == loopback, "{} is allowed", url.text);
  FURNACE_CHECK(!list.allows_address(url, loopback) || (url.address == loopback && url.port == 9000),
                "{} leads inside", url.text);
}

// Input: an allow-list, which is also taken for a relative reference; behind a zero byte a URL.
void run_outbound_url(Input input) {
  const TextPair texts = split(input);
  static const OutboundUrl base = *parse_outbound_url("https://example.com/a/b.gltf?c");
  if (const auto url = resolve_outbound_url(base, texts.first)) check_outbound_url(*url);
  const auto url = parse_outbound_url(texts.second);
  if (url) check_outbound_url(*url);
  if (!url || !AllowList::fault(texts.first).empty()) return;
  const AllowList list(texts.first);
  FURNACE_CHECK(!list.allows(*url) || !list.empty(), "an empty list allows {}", url->text);
}

void run_preset(Input input) {
  const api::Preset preset = api::parse_preset(text_of(input), {});
  for (const std::string& key : preset.open)
    FURNACE_CHECK(api::find_query_key(key) != nullptr, "{} is open", key);
  FURNACE_CHECK(api::parse_preset(preset.document, {}).document == preset.document,
                "another reading, another request");
}

// Whatever comes, our own field is valid, and it is of the trace that a valid one names.
void run_traceparent(Input input) {
  const std::string_view field = text_of(input);
  const TraceContext context = trace_of(field);
  const TraceContext next = trace_of(context.text());
  FURNACE_CHECK(next.trace_id == context.trace_id && next.parent_id == context.span_id, "{}", context.text());
  FURNACE_CHECK(context.parent_id.empty() || field.find(context.trace_id) == 3, "{}", context.text());
}

constexpr std::array kTargets = {
    Target{"image_url", run_image_url, kMostUrlBytes, mutate_bytes},
    Target{"keys", run_keys, kMostUrlBytes, mutate_bytes},
    Target{"outbound_url", run_outbound_url, kMostUrlBytes, mutate_bytes},
    Target{"preset", run_preset, kMostUrlBytes, mutate_bytes},
    Target{"traceparent", run_traceparent, 256, mutate_bytes},
};

}  // namespace

std::span<const Target> url_targets() {
  return kTargets;
}

}  // namespace furnace::fuzz
