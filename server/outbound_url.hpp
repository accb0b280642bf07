// URLs that the server is asked to call, and the operator's list of those it may call. libcurl reads the URLs, here as when it
// connects, so that both mean the same host.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/outbound_address.hpp"

namespace furnace {

// Threads: a value.
struct OutboundUrl {
  std::string text;    // whole, without fragment
  std::string scheme;  // "http" or "https"
  std::string host;    // lower case; an address of IPv6 without brackets
  int port = 0;        // the scheme's own where none is written
  std::string path;    // without "." and ".." segments
  bool has_query = false;
  std::optional<NetworkAddress> address;  // when the host is one

  bool has_origin_of(const OutboundUrl& other) const {
    return scheme == other.scheme && host == other.host && port == other.port;
  }
};

// None unless it is http or https with a plain host, of at most 2048 bytes: no user, no zone, no name outside of ASCII (it is
// written in Punycode), no name that ends with a dot or a number.
std::optional<OutboundUrl> parse_outbound_url(std::string_view text);
// As RFC 3986, section 5 resolves it, spaces and other bytes percent-encoded. None as above.
std::optional<OutboundUrl> resolve_outbound_url(const OutboundUrl& base, std::string_view reference);

// "example.com" and "*.example.com" (its subdomains), which are https on port 443; an origin as "https://example.com:8443" or
// "http://127.0.0.1:9000"; "*" is https on port 443 of any name; "10.0.0.0/8" is no host, but a network in which the hosts may lie.
// Separated by commas. The rest is refused.
// Threads: a value.
class AllowList {
 public:
  AllowList() = default;  // nothing
  // `list` has no fault.
  explicit AllowList(std::string_view list);
  static std::string fault(std::string_view list);  // "" when there is none

  bool empty() const { return rules_.empty(); }
  bool allows(const OutboundUrl& url) const;
  // Whether the host of an allowed URL may be reached at this address: a public one; any other only where the operator wrote
  // that very address as an origin, or a network that has it.
  bool allows_address(const OutboundUrl& url, const NetworkAddress& address) const;

 private:
  struct Rule {
    enum class Kind { kAny, kSubdomains, kHost, kOrigin } kind;
    OutboundUrl url;
  };
  static std::optional<Rule> parse_rule(std::string_view entry);

  std::vector<Rule> rules_;
  std::vector<Network> networks_;
};

}  // namespace furnace
