// Numbers as text formats write them.
#pragma once

#include <optional>
#include <string_view>

namespace furnace {

// Of all of the word, which a plus may begin; "inf" and "nan" are numbers too. Too small for a double is 0, too large is
// infinite.
std::optional<double> number_in(std::string_view word);

}  // namespace furnace
