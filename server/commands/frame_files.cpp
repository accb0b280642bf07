#include "server/commands/frame_files.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace furnace {

namespace {

constexpr int kMostDigits = 9;

struct Place {
  std::size_t begin = 0, size = 0;
  int digits = 0;
};

// The first "%d", "%4d" or "%04d", or run of "#", from `from` on.
std::optional<Place> find_place(std::string_view name, std::size_t from) {
  for (std::size_t i = from; i < name.size(); ++i) {
    if (name[i] == '#') {
      const std::size_t end = std::min(name.find_first_not_of('#', i), name.size());
      return Place{i, end - i, int(end - i)};
    }
    if (name[i] != '%') continue;
    std::size_t end = i + 1;
    int digits = 0;
    while (end < name.size() && name[end] >= '0' && name[end] <= '9' && digits <= kMostDigits)
      digits = digits * 10 + (name[end++] - '0');
    if (end < name.size() && name[end] == 'd') return Place{i, end + 1 - i, std::max(1, digits)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<FrameFiles> FrameFiles::parse(std::string_view name) {
  const auto place = find_place(name, 0);
  if (!place || place->digits > kMostDigits) return std::nullopt;
  const std::size_t end = place->begin + place->size;
  if (find_place(name, end)) return std::nullopt;
  return FrameFiles(std::string(name.substr(0, place->begin)), place->digits, std::string(name.substr(end)));
}

std::string FrameFiles::name_of(int frame) const {
  return fmt::format("{}{:0{}}{}", before_, frame + 1, digits_, after_);
}

}  // namespace furnace
