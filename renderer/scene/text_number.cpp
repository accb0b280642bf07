#include "renderer/scene/text_number.hpp"

#include <charconv>
#include <cstdlib>
#include <string>
#include <system_error>

namespace furnace {

std::optional<double> number_in(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double number = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (fault == std::errc::invalid_argument || end != word.data() + word.size()) return std::nullopt;
  if (fault == std::errc::result_out_of_range) number = std::strtod(std::string(word).c_str(), nullptr);
  return number;
}

}  // namespace furnace
