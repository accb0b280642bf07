#include "server/outbound_url.hpp"
#include "server/field_text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <memory>

#include <curl/curl.h>
#include <fmt/format.h>

namespace furnace {
namespace {

constexpr std::size_t kMostUrlBytes = 2048;
constexpr int kHttpsPort = 443;
constexpr std::string_view kSubdomains = "*.";

struct FreeUrl {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
using CurlUrl = std::unique_ptr<CURLU, FreeUrl>;

std::optional<std::string> part_of(const CurlUrl& url, CURLUPart part, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url.get(), part, &text, flags) != CURLUE_OK) return std::nullopt;
  std::string out(text);
  curl_free(text);
  return out;
}

bool set(const CurlUrl& url, CURLUPart part, const std::string& text, unsigned flags = 0) {
  return text.find('\0') == std::string::npos &&
         curl_url_set(url.get(), part, text.c_str(), flags) == CURLUE_OK;
}

// Of RFC 1123, and the underscore that is in use. A name that ends with a number is an address in some reader's eyes (WHATWG
// URL, "ends in a number"); libcurl has made an address of what it takes for one.
bool is_plain_name(std::string_view name) {
  const auto is_plain = [](unsigned char c) {
    return (c < 0x80 && std::isalnum(c)) || c == '-' || c == '.' || c == '_';
  };
  if (name.empty() || name.front() == '.' || name.back() == '.' || name.find("..") != name.npos) return false;
  const std::string_view last = name.substr(name.rfind('.') + 1);
  return std::ranges::all_of(name, is_plain) && !std::isdigit(static_cast<unsigned char>(last.front()));
}

std::optional<OutboundUrl> read(const CurlUrl& url) {
  OutboundUrl out;
  const auto scheme = part_of(url, CURLUPART_SCHEME), host = part_of(url, CURLUPART_HOST);
  const auto port = part_of(url, CURLUPART_PORT, CURLU_DEFAULT_PORT), path = part_of(url, CURLUPART_PATH);
  if (!scheme || !host || !port || !path || part_of(url, CURLUPART_ZONEID)) return std::nullopt;
  out.scheme = lower(*scheme);
  if (out.scheme != "http" && out.scheme != "https") return std::nullopt;
  out.host = lower(*host);
  const bool has_brackets = out.host.size() > 2 && out.host.front() == '[' && out.host.back() == ']';
  if (!set(url, CURLUPART_HOST, out.host)) return std::nullopt;
  if (has_brackets) out.host = out.host.substr(1, out.host.size() - 2);
  out.address = parse_network_address(out.host);
  if (!out.address && (has_brackets || !is_plain_name(out.host))) return std::nullopt;
  std::from_chars(port->data(), port->data() + port->size(), out.port);
  if (out.port <= 0) return std::nullopt;
  out.path = *path;
  out.has_query = part_of(url, CURLUPART_QUERY).has_value();
  curl_url_set(url.get(), CURLUPART_FRAGMENT, nullptr, 0);
  const auto text = part_of(url, CURLUPART_URL);
  if (!text || text->size() > kMostUrlBytes) return std::nullopt;
  out.text = *text;
  return out;
}

bool is_subdomain(std::string_view name, std::string_view of) {
  return name.size() > of.size() + 1 && name.ends_with(of) && name[name.size() - of.size() - 1] == '.';
}

std::vector<std::string_view> entries_of(std::string_view list) {
  std::vector<std::string_view> entries;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    if (const std::string_view entry = trimmed(list.substr(0, end)); !entry.empty()) entries.push_back(entry);
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return entries;
}

}  // namespace

std::optional<OutboundUrl> parse_outbound_url(std::string_view text) {
  if (text.size() > kMostUrlBytes) return std::nullopt;
  const CurlUrl url(curl_url());
  if (!url || !set(url, CURLUPART_URL, std::string(text), CURLU_DISALLOW_USER)) return std::nullopt;
  return read(url);
}

std::optional<OutboundUrl> resolve_outbound_url(const OutboundUrl& base, std::string_view reference) {
  if (reference.size() > kMostUrlBytes) return std::nullopt;
  const CurlUrl url(curl_url());
  if (!url || !set(url, CURLUPART_URL, base.text)) return std::nullopt;
  if (!set(url, CURLUPART_URL, std::string(reference), CURLU_DISALLOW_USER | CURLU_URLENCODE))
    return std::nullopt;
  return read(url);
}

std::optional<AllowList::Rule> AllowList::parse_rule(std::string_view entry) {
  using Kind = Rule::Kind;
  if (entry == "*") return Rule{Kind::kAny, {}};
  if (entry.find("://") != entry.npos) {
    const auto url = parse_outbound_url(entry);
    if (!url || url->path != "/" || url->has_query || entry.find('#') != entry.npos) return std::nullopt;
    return Rule{Kind::kOrigin, *url};
  }
  const bool is_suffix = entry.starts_with(kSubdomains);
  if (is_suffix) entry.remove_prefix(kSubdomains.size());
  const auto url = parse_outbound_url(fmt::format("https://{}/", entry));
  // What libcurl has read is what was written: no port, path or user is hidden in it, no address is written otherwise.
  if (!url || url->host != lower(std::string(entry)) || url->address) return std::nullopt;
  return Rule{is_suffix ? Kind::kSubdomains : Kind::kHost, *url};
}

std::string AllowList::fault(std::string_view list) {
  for (const std::string_view entry : entries_of(list))
    if (!parse_rule(entry) && !parse_network(entry))
      return fmt::format(
          "'{}' is not a host such as example.com or *.example.com, nor an origin such as "
          "https://example.com:8443, nor a network such as 10.0.0.0/8",
          entry);
  return {};
}

AllowList::AllowList(std::string_view list) {
  for (const std::string_view entry : entries_of(list)) {
    if (auto rule = parse_rule(entry)) rules_.push_back(*std::move(rule));
    if (const auto network = parse_network(entry)) networks_.push_back(*network);
  }
}

bool AllowList::allows(const OutboundUrl& url) const {
  using Kind = Rule::Kind;
  const bool is_plain_https = url.scheme == "https" && url.port == kHttpsPort && !url.address;
  return std::ranges::any_of(rules_, [&](const Rule& rule) {
    switch (rule.kind) {
      case Kind::kAny:
        return is_plain_https;
      case Kind::kSubdomains:
        return is_plain_https && is_subdomain(url.host, rule.url.host);
      case Kind::kHost:
        return is_plain_https && url.host == rule.url.host;
      case Kind::kOrigin:
        break;
    }
    return url.has_origin_of(rule.url);
  });
}

bool AllowList::allows_address(const OutboundUrl& url, const NetworkAddress& address) const {
  const auto has_it = [&](const Network& network) { return network.contains(address); };
  if (is_public(address) || std::ranges::any_of(networks_, has_it)) return true;
  return url.address == address && std::ranges::any_of(rules_, [&](const Rule& rule) {
           return rule.kind == Rule::Kind::kOrigin && url.has_origin_of(rule.url);
         });
}

}  // namespace furnace
