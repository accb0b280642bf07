// Parts of a reply (RFC 9110 section 14.2): what a client still lacks of a large file.
#pragma once

#include <cstdint>
#include <string_view>

#include "server/http_types.hpp"

namespace furnace {

// What a Range field asks of so many bytes.
struct RangeWish {
  enum class Kind { kWhole, kPart, kNone } kind = Kind::kWhole;  // kNone: nothing of it is there
  ByteRange part = {};
};
// One range; several, and what is not understood, are the whole.
RangeWish wished_range(std::string_view field, std::int64_t total);

// Makes of the whole file that a GET is answered with the part that it asks for, or 416; tells that parts may be had. Only of
// what has a strong entity tag, by which a client knows that its parts are of one file.
void serve_range(const Request& request, Reply& reply);
bool says_ranges(const Reply& reply);  // that parts may be had

}  // namespace furnace
