// Whom the server may call: addresses, URLs, the operator's list.
#include <functional>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <gtest/gtest.h>

#include "server/outbound_url.hpp"

namespace furnace {
namespace {

bool is_public_text(const std::string& text) {
  const auto address = parse_network_address(text);
  EXPECT_TRUE(address) << text;
  return address && is_public(*address);
}

TEST(OutboundAddress, PublicOnes) {
  for (const char* text : {"1.1.1.1",         "9.255.255.255",
                           "11.0.0.0",        "100.63.255.255",
                           "100.128.0.0",     "126.255.255.255",
                           "128.0.0.0",       "168.63.129.15",
                           "168.63.129.17",   "169.253.255.255",
                           "169.255.0.0",     "172.15.255.255",
                           "172.32.0.0",      "192.0.1.0",
                           "192.0.3.0",       "192.167.255.255",
                           "192.169.0.0",     "198.17.255.255",
                           "198.20.0.0",      "223.255.255.255",
                           "2001:200::1",     "2001:4860:4860::8888",
                           "2606:4700::1111", "2a00:1450:4001::200e",
                           "2003::1",         "2001:db7:ffff::",
                           "2001:db9::",      "3ffe::1"})
    EXPECT_TRUE(is_public_text(text)) << text;
}

TEST(OutboundAddress, AllOthersAreRefused) {
  for (const char* text :
       {"0.0.0.0", "0.255.255.255", "10.0.0.0", "10.255.255.255", "100.64.0.0", "100.100.100.200",
        "100.127.255.255", "127.0.0.1", "127.255.255.255", "168.63.129.16", "169.254.0.0", "169.254.169.254",
        "172.16.0.0", "172.31.255.255", "192.0.0.0", "192.0.0.192", "192.0.2.1", "192.88.99.1", "192.168.0.0",
        "192.168.255.255", "198.18.0.0", "198.19.255.255", "198.51.100.7", "203.0.113.9", "224.0.0.1",
        "239.255.255.255", "240.0.0.0", "255.255.255.255",
        // IPv6: unspecified, loopback, discard, local in all its forms, multicast, documents
        "::", "::1", "100::1", "fc00::1", "fd00:ec2::254", "fe80::1", "febf::1", "fec0::1", "feff::1",
        "ff02::1", "2001:db8::1", "3fff::1", "5f00::1", "4000::1",
        // with an address of IPv4 in it: mapped, compatible, translated, NAT64 twice, Teredo, 6to4, ISATAP
        "::ffff:127.0.0.1", "::ffff:8.8.8.8", "::127.0.0.1", "::8.8.8.8", "::ffff:0:8.8.8.8",
        "64:ff9b::8.8.8.8", "64:ff9b::169.254.169.254", "64:ff9b:1::1", "2001::1",
        "2001:0:53aa:64c:0:fffe:7f00:1", "2001:2::1", "2001:10::1", "2001:20::1", "2001:1ff:ffff::1",
        "2002:7f00:1::", "2002:808:808::1", "2a00::5efe:127.0.0.1", "2a00::200:5efe:10.0.0.1"})
    EXPECT_FALSE(is_public_text(text)) << text;
}

TEST(OutboundAddress, TextIsReadStrictly) {
  for (const char* text : {"", "127.1", "0177.0.0.1", "0x7f.0.0.1", "2130706433", "127.0.0.1.", "127.0.0.1 ",
                           "[::1]", "::1%lo", "1.2.3", "1.2.3.4.5", "localhost", "::ffff:127.1"})
    EXPECT_FALSE(parse_network_address(text)) << text;
  EXPECT_FALSE(parse_network_address(std::string("1.1.1.1\0x", 9)));
}

TEST(OutboundAddress, AsTheSystemGivesIt) {
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  v4.sin_addr.s_addr = htonl(0x7f000001);
  EXPECT_EQ(network_address_of(reinterpret_cast<const sockaddr&>(v4)), parse_network_address("127.0.0.1"));
  sockaddr_in6 v6{};
  v6.sin6_family = AF_INET6;
  v6.sin6_addr = in6addr_loopback;
  EXPECT_EQ(network_address_of(reinterpret_cast<const sockaddr&>(v6)), parse_network_address("::1"));
  sockaddr other{};
  other.sa_family = AF_UNIX;
  EXPECT_FALSE(network_address_of(other));
}

struct Spelling {
  std::string url, host;
  int port;
};

TEST(OutboundUrl, SpellingsOfOneHost) {
  for (const Spelling& row : std::vector<Spelling>{
           {"https://example.com", "example.com", 443},
           {"HTTPS://EXAMPLE.com/a", "example.com", 443},
           {"https://example.com:443/", "example.com", 443},
           {"https://example.com:/", "example.com", 443},
           {"https://example.com:8443/", "example.com", 8443},
           {"http://example.com?q", "example.com", 80},
           {"https://ex%61mple.com/", "example.com", 443},
           {"https://xn--bcher-kva.example/", "xn--bcher-kva.example", 443},
           {"https://a_b.example.com/", "a_b.example.com", 443},
           {"http://127.0.0.1:9000/", "127.0.0.1", 9000},
           {"http://0177.0.0.1/", "127.0.0.1", 80},
           {"http://0x7f.1/", "127.0.0.1", 80},
           {"http://2130706433/", "127.0.0.1", 80},
           {"http://127.1/", "127.0.0.1", 80},
           {"http://[::1]:9000/", "::1", 9000},
           {"https://example.com/#@evil.example", "example.com", 443},
           {"https://example.com/@evil.example", "example.com", 443},
       }) {
    const auto url = parse_outbound_url(row.url);
    ASSERT_TRUE(url) << row.url;
    EXPECT_EQ(url->host, row.host) << row.url;
    EXPECT_EQ(url->port, row.port) << row.url;
  }
}

TEST(OutboundUrl, WhatIsRefused) {
  for (const std::string& text : std::vector<std::string>{"",
                                                          "example.com",
                                                          "//example.com",
                                                          "https:",
                                                          "https://",
                                                          "https:///",
                                                          "https://:443",
                                                          "ftp://example.com",
                                                          "file:///etc/passwd",
                                                          "gopher://example.com",
                                                          "javascript:alert(1)",
                                                          "https://a@b",
                                                          "https://a:b@c",
                                                          "https://good.example@evil.example/",
                                                          "https://good.example\\@evil.example/",
                                                          "https://example.com:0",
                                                          "https://example.com:65536",

                                                          "https://example.com:x",
                                                          "https://example.com.",
                                                          "https://example..com",
                                                          "https://.example.com",
                                                          "https://exa mple.com",
                                                          "https://exa\tmple.com",
                                                          "https://example.com\r\nHost: a",
                                                          "https://b\xc3\xbc"
                                                          "cher.example/",
                                                          "https://[::1",
                                                          "https://[::1%25lo]/",
                                                          "https://[::1]x/",
                                                          "https://[1.2.3.4]/",
                                                          "https://1.2.3.4.5/",
                                                          "https://256.256.256.256/",
                                                          "https://example.0x1/",
                                                          "https://127.0.0.1./",
                                                          "https://%00/",
                                                          "https://a%2fb/",
                                                          "https://*.example.com/",
                                                          "https://a,b/",
                                                          "https://example.com/" + std::string(2048, 'a'),
                                                          std::string("https://a\0b", 11)})
    EXPECT_FALSE(parse_outbound_url(text)) << text;
}

TEST(OutboundUrl, RelativeOnes) {
  const OutboundUrl base = *parse_outbound_url("https://example.com:8443/a/b/model.gltf?v=1#x");
  EXPECT_EQ(base.text, "https://example.com:8443/a/b/model.gltf?v=1");
  const auto resolved = [&](const std::string& text) {
    const auto url = resolve_outbound_url(base, text);
    return url ? url->text : "(none)";
  };
  EXPECT_EQ(resolved("c.bin"), "https://example.com:8443/a/b/c.bin");
  EXPECT_EQ(resolved("../c.bin"), "https://example.com:8443/a/c.bin");
  EXPECT_EQ(resolved("/c.bin"), "https://example.com:8443/c.bin");
  EXPECT_EQ(resolved("https://other.example/x"), "https://other.example/x");
  EXPECT_EQ(resolved("//other.example/x"), "https://other.example/x");
  EXPECT_EQ(resolved("https://u@other.example/x"), "(none)");
  EXPECT_EQ(resolved("file:///etc/passwd"), "(none)");
}

struct Judged {
  std::string list, url;
  bool allowed;
};

TEST(AllowList, WhatItAllows) {
  for (const Judged& row : std::vector<Judged>{
           {"", "https://example.com/", false},
           {"example.com", "https://example.com/a?b", true},
           {"example.com", "HTTPS://EXAMPLE.COM/", true},
           {"EXAMPLE.com", "https://example.com/", true},
           {"example.com", "http://example.com/", false},
           {"example.com", "https://example.com:8443/", false},
           {"example.com", "https://a.example.com/", false},
           {"b.example", "https://ab.example/", false},
           {"example.com", "https://example.com.evil.example/", false},
           {"*.example.com", "https://a.example.com/", true},
           {"*.example.com", "https://a.b.example.com/", true},
           {"*.example.com", "https://example.com/", false},
           {"*.b.example", "https://ab.example/", false},
           {"*.example.com", "http://a.example.com/", false},
           {" a.example , b.example ,", "https://b.example/", true},
           {"https://example.com:8443", "https://example.com:8443/x", true},
           {"https://example.com:8443", "https://example.com/x", false},
           {"http://127.0.0.1:9000", "http://127.0.0.1:9000/x", true},
           {"http://127.0.0.1:9000", "http://127.1:9000/x", true},
           {"http://127.0.0.1:9000", "http://127.0.0.1:9001/x", false},
           {"http://127.0.0.1:9000", "http://localhost:9000/x", false},
           {"http://127.0.0.1:9000", "https://127.0.0.1:9000/x", false},
           {"http://[::1]:9000", "http://[0:0::1]:9000/x", true},
           {"*", "https://anything.example/", true},
           {"*", "http://anything.example/", false},
           {"*", "https://anything.example:8443/", false},
           {"*", "https://8.8.8.8/", false},
       }) {
    EXPECT_EQ(AllowList::fault(row.list), "") << row.list;
    EXPECT_EQ(AllowList(row.list).allows(*parse_outbound_url(row.url)), row.allowed)
        << row.list << " " << row.url;
  }
}

TEST(AllowList, Faults) {
  for (const char* list : {"example.com:8443",
                           "example.com/path",
                           "a@example.com",
                           "https://example.com/path",
                           "https://a@example.com",
                           "https://example.com/?q",
                           "https://example.com/#f",
                           "ftp://a",
                           "http://*.example.com",
                           "**.example.com",
                           "*.*.example.com",
                           "*example.com",
                           "127.0.0.1",
                           "*.127.0.0.1",
                           "10.0.0.1/8",
                           "10.0.0.0/33",
                           "10.0.0.0/",
                           "10.0.0/8",
                           "10.0.0.0/-1",
                           "10.0.0.0/8/8",
                           "fd00::/129",
                           "[::1]",
                           "example.com.",
                           "exa mple.com",
                           "2130706433",
                           "*."})
    EXPECT_NE(AllowList::fault(list), "") << list;
  EXPECT_EQ(AllowList::fault(" , ,"), "");
  EXPECT_TRUE(AllowList(" , ,").empty());
}

TEST(AllowList, OnlyAnAddressThatWasWrittenMayBePrivate) {
  const AllowList list(
      "example.com, localhost, https://intranet.example:8443, http://127.0.0.1:9000, http://[::1]:9000");
  const auto may = [&](const char* url, const char* address) {
    return list.allows_address(*parse_outbound_url(url), *parse_network_address(address));
  };
  EXPECT_TRUE(may("https://example.com/", "93.184.215.14"));
  EXPECT_FALSE(may("https://example.com/", "127.0.0.1"));
  EXPECT_FALSE(may("https://localhost/", "127.0.0.1"));
  EXPECT_FALSE(may("https://intranet.example:8443/", "10.1.2.3"));
  EXPECT_TRUE(may("http://127.0.0.1:9000/", "127.0.0.1"));
  EXPECT_FALSE(may("http://127.0.0.1:9000/", "127.0.0.2"));
  EXPECT_FALSE(may("http://127.0.0.1:9001/", "127.0.0.1"));
  EXPECT_TRUE(may("http://[::1]:9000/", "::1"));
  EXPECT_FALSE(may("http://[::1]:9000/", "127.0.0.1"));
}

TEST(AllowList, HostsMayLieInANetworkThatWasWritten) {
  const AllowList list("http://app:3000, example.com, 10.0.0.0/9, fd00:1::/33, 192.0.2.7/32");
  const auto may = [&](const char* url, const char* address) {
    return list.allows_address(*parse_outbound_url(url), *parse_network_address(address));
  };
  EXPECT_TRUE(list.allows(*parse_outbound_url("http://app:3000/hook")));
  EXPECT_FALSE(list.allows(*parse_outbound_url("http://10.0.0.1/"))) << "a network is no host";
  EXPECT_TRUE(may("http://app:3000/", "10.0.0.0"));
  EXPECT_TRUE(may("http://app:3000/", "10.127.255.255"));
  EXPECT_FALSE(may("http://app:3000/", "10.128.0.0"));
  EXPECT_FALSE(may("http://app:3000/", "127.0.0.1"));
  EXPECT_TRUE(may("https://example.com/", "fd00:1:7fff::1"));
  EXPECT_FALSE(may("https://example.com/", "fd00:1:8000::1"));
  EXPECT_TRUE(may("https://example.com/", "192.0.2.7"));
  EXPECT_FALSE(may("https://example.com/", "192.0.2.6"));
  EXPECT_FALSE(may("https://example.com/", "::ffff:10.0.0.1"))
      << "it is asked for as what it carries, or not";
}

}  // namespace
}  // namespace furnace
