// The query of a URL as pairs, and texts in the alphabet of URLs.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/image_query.hpp"

namespace furnace {

// application/x-www-form-urlencoded, as browsers write it: "&" between pairs, "+" is a space, a pair without "=" has an
// empty value, empty pairs are passed over. None when a "%" is not followed by two hexadecimal digits.
std::optional<std::vector<api::QueryPair>> parse_query(std::string_view query);

// Letters, digits, "-", ".", "_" and "~" stay as they are (RFC 3986 section 2.3), each other byte is "%" and two upper-case
// hexadecimal digits.
std::string percent_encoded(std::string_view text);

// The one text of these pairs: names and values percent_encoded.
std::string canonical_query(std::span<const api::QueryPair> pairs);

// RFC 4648 section 5. Without padding when written; read with or without.
std::string base64url(std::string_view bytes);
// None for anything but what base64url writes, padded or not.
std::optional<std::string> base64url_decoded(std::string_view text);

}  // namespace furnace
