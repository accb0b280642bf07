// A request's body as a document and the files that it may name.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "renderer/base/blob.hpp"
#include "server/http_types.hpp"

namespace furnace {

struct RequestBody {
  std::string_view document = "{}";   // into the request's body
  std::map<std::string, Blob> parts;  // by part name and by file name
};

// application/json, multipart/form-data with a part "request", or nothing.
// Errors: kUnsupportedMedia for another type; those of parse_multipart.
RequestBody read_body(const Request& request, int max_parts);

}  // namespace furnace
