#include "server/outbound_address.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <span>
#include <string>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace furnace {
namespace {

constexpr std::size_t kV4Bytes = 4, kV6Bytes = 16;

struct Range {
  std::array<std::uint8_t, kV6Bytes> prefix;
  int bits;
};

// IANA IPv4 Special-Purpose Address Registry (RFC 6890), and what clouds serve beside it.
constexpr Range kV4Refused[] = {
    {{0}, 8},                  // this network
    {{10}, 8},                 // private
    {{100, 64}, 10},           // shared by a provider's customers
    {{127}, 8},                // loopback
    {{168, 63, 129, 16}, 32},  // Azure's host
    {{169, 254}, 16},          // link-local; the clouds' metadata
    {{172, 16}, 12},           // private
    {{192, 0, 0}, 24},         // IETF
    {{192, 0, 2}, 24},         // documents
    {{192, 88, 99}, 24},       // 6to4 relays
    {{192, 168}, 16},          // private
    {{198, 18}, 15},           // benchmarks
    {{198, 51, 100}, 24},      // documents
    {{203, 0, 113}, 24},       // documents
    {{224}, 4},                // multicast
    {{240}, 4},                // reserved, broadcast
};

// All that IANA has given out for public use. What lies outside is refused: loopback, mapped and compatible IPv4, NAT64
// (64:ff9b::/96, 64:ff9b:1::/48), unique local (fc00::/7), link-local (fe80::/10), site-local (fec0::/10), multicast.
constexpr Range kV6Public = {{0x20}, 3};
constexpr Range kV6Refused[] = {
    {{0x20, 0x01, 0x00}, 23},        // IETF: Teredo, benchmarks, ORCHID
    {{0x20, 0x01, 0x0d, 0xb8}, 32},  // documents
    {{0x20, 0x02}, 16},              // 6to4
    {{0x3f, 0xff, 0x00}, 20},        // documents
};

bool is_within(const NetworkAddress& address, const Range& range) {
  const int whole = range.bits / 8, rest = range.bits % 8;
  if (!std::equal(range.prefix.begin(), range.prefix.begin() + whole, address.bytes.begin())) return false;
  const int mask = 0xff & (0xff00 >> rest);
  return rest == 0 || (address.bytes[std::size_t(whole)] & mask) == range.prefix[std::size_t(whole)];
}

bool is_in_any(const NetworkAddress& address, std::span<const Range> ranges) {
  return std::ranges::any_of(ranges, [&](const Range& range) { return is_within(address, range); });
}

// RFC 5214 section 6.1: an interface whose last four bytes are an IPv4 address, whatever the network.
bool is_isatap(const NetworkAddress& address) {
  constexpr std::array<std::uint8_t, 3> kMark = {0x00, 0x5e, 0xfe};
  return (address.bytes[8] & 0xfd) == 0 && std::equal(kMark.begin(), kMark.end(), address.bytes.begin() + 9);
}

}  // namespace

std::optional<NetworkAddress> parse_network_address(std::string_view text) {
  const std::string terminated(text);
  if (terminated.find('\0') != std::string::npos) return std::nullopt;
  NetworkAddress address;
  if (::inet_pton(AF_INET, terminated.c_str(), address.bytes.data()) == 1) return address;
  address.is_v6 = ::inet_pton(AF_INET6, terminated.c_str(), address.bytes.data()) == 1;
  return address.is_v6 ? std::optional(address) : std::nullopt;
}

bool Network::contains(const NetworkAddress& address) const {
  return address.is_v6 == prefix.is_v6 && is_within(address, {prefix.bytes, bits});
}

std::optional<Network> parse_network(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == text.npos) return std::nullopt;
  const auto prefix = parse_network_address(text.substr(0, slash));
  const std::string_view digits = text.substr(slash + 1);
  int bits = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), bits);
  if (!prefix || fault != std::errc{} || end != digits.data() + digits.size() || bits < 0 ||
      std::size_t(bits) > 8 * (prefix->is_v6 ? kV6Bytes : kV4Bytes))
    return std::nullopt;
  NetworkAddress first = *prefix;
  for (std::size_t bit = std::size_t(bits); bit < 8 * kV6Bytes; ++bit)
    first.bytes[bit / 8] &= std::uint8_t(~(0x80 >> bit % 8));
  if (first != *prefix) return std::nullopt;
  return Network{first, bits};
}

std::optional<NetworkAddress> network_address_of(const sockaddr& address) {
  NetworkAddress out;
  if (address.sa_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof v4);
    std::memcpy(out.bytes.data(), &v4.sin_addr, kV4Bytes);
    return out;
  }
  if (address.sa_family != AF_INET6) return std::nullopt;
  sockaddr_in6 v6{};
  std::memcpy(&v6, &address, sizeof v6);
  std::memcpy(out.bytes.data(), &v6.sin6_addr, kV6Bytes);
  out.is_v6 = true;
  return out;
}

bool is_public(const NetworkAddress& address) {
  if (!address.is_v6) return !is_in_any(address, kV4Refused);
  return is_within(address, kV6Public) && !is_in_any(address, kV6Refused) && !is_isatap(address);
}

}  // namespace furnace
