// Header fields that decide which answer is given: media types, Accept, If-None-Match.
#pragma once

#include <string>
#include <string_view>

namespace furnace {

// "Text/HTML; charset=utf-8" -> "text/html".
std::string media_type_essence(std::string_view content_type);

// Value of a parameter such as boundary, quotes removed; "" when it is not there.
std::string media_type_parameter(std::string_view content_type, std::string_view name);

// How much an Accept field wants `media_type`: 0 (refused) to 1, the most specific range decides (RFC 9110
// section 12.5.1). An empty field accepts everything.
double accept_quality(std::string_view accept, std::string_view media_type);

// If-None-Match with weak comparison (RFC 9110 section 13.1.2). "*" never matches: a picture not yet drawn
// has no current representation.
bool etag_matches(std::string_view if_none_match, std::string_view etag);

}  // namespace furnace
