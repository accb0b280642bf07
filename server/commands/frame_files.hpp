// Names of the files of a sequence, from one name with a place for the number.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace furnace {

// "frame_%04d.png" or "frame_####.png": counted from 1, with at least so many digits.
class FrameFiles {
 public:
  // None for a name without exactly one such place.
  static std::optional<FrameFiles> parse(std::string_view name);
  std::string name_of(int frame) const;  // `frame` from 0

 private:
  FrameFiles(std::string before, int digits, std::string after)
      : before_(std::move(before)), digits_(digits), after_(std::move(after)) {}

  std::string before_;
  int digits_;
  std::string after_;
};

}  // namespace furnace
