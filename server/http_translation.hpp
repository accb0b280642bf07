// Between the library's messages and ours.
#pragma once

#include <map>
#include <string>

#include <httplib.h>

#include "server/http_types.hpp"

namespace furnace {

// Repeated fields joined by ", "; without what the library puts among them.
std::map<std::string, std::string, HeaderLess> joined_headers(const httplib::Headers& headers);

void fill(httplib::Response& out, Reply reply);

}  // namespace furnace
