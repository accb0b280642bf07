// Which program this is: the version and a hash of the sources it was built from.
#pragma once

#include <string_view>

namespace furnace {

std::string_view version();   // "0.1.0"
std::string_view build_id();  // "0.1.0+9f2c41d07a3b"

}  // namespace furnace
