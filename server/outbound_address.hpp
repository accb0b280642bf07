// Which addresses of the network the server may call on somebody's behalf.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

struct sockaddr;

namespace furnace {

// Threads: a value.
struct NetworkAddress {
  std::array<std::uint8_t, 16> bytes{};  // in the network's order; of IPv4 the first four
  bool is_v6 = false;

  bool operator==(const NetworkAddress&) const = default;
};

// Addresses with the same first bits. Threads: a value.
struct Network {
  NetworkAddress prefix;  // its other bits are 0
  int bits = 0;

  bool contains(const NetworkAddress& address) const;
};

// "192.0.2.1" or "2001:db8::1", nothing else: no brackets, no zone, no octal or shortened forms.
std::optional<NetworkAddress> parse_network_address(std::string_view text);
// "10.0.0.0/8", "fd00::/8"; none where bits are set beyond the prefix.
std::optional<Network> parse_network(std::string_view text);
// None for a family that is neither IPv4 nor IPv6.
std::optional<NetworkAddress> network_address_of(const sockaddr& address);

// An address of the public Internet that stands for itself: not of this machine, of a private, shared or local network, for
// many, reserved or for documents, of a cloud's own services; not one of IPv6 that carries another of IPv4 in it.
bool is_public(const NetworkAddress& address);

}  // namespace furnace
