// multipart/form-data (RFC 7578) of a body that is already in memory.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct Part {
  std::string name;
  std::string file_name;  // "" when it is not a file
  std::string_view body;  // into the request's body
};

// `content_type` is the whole field, with its boundary.
// Errors: kInvalidRequest for what is not well-formed; kTooLarge for more than `max_parts`.
std::vector<Part> parse_multipart(std::string_view body, std::string_view content_type, int max_parts);

}  // namespace furnace
