#include "server/http_stream.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "server/negotiation.hpp"

namespace furnace {

std::string HttpStream::end_head() {
  in_head_ = false;
  return std::exchange(range_, {});
}

ssize_t HttpStream::read(char* out, size_t size) {
  if (!in_head_) return io_.read(out, size);
  if (next_ == line_.size() && !next_line()) return -1;
  const std::size_t count = std::min(size, line_.size() - next_);
  std::copy_n(line_.data() + next_, count, out);
  next_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t HttpStream::write(const char* data, size_t size) {
  return io_.write(data, size) ? static_cast<ssize_t>(size) : -1;
}

bool HttpStream::next_line() {
  next_ = 0;
  do {
    line_.clear();
    for (char c = 0; c != '\n' && io_.read(&c, 1) == 1;) line_ += c;
  } while (in_fields_ && takes_range());
  in_fields_ = true;
  return !line_.empty();
}

// Whether the line is a Range field, which is kept then.
bool HttpStream::takes_range() {
  constexpr std::string_view kSpace = " \t\r\n", kName = "range";
  const std::string_view line = line_;
  const std::size_t colon = line.find(':');
  if (!line.ends_with('\n') || colon == line.npos || media_type_essence(line.substr(0, colon)) != kName)
    return false;
  const std::size_t first = line.find_first_not_of(kSpace, colon + 1);
  if (first == line.npos) return true;
  if (!range_.empty()) range_ += ", ";
  range_ += line.substr(first, line.find_last_not_of(kSpace) + 1 - first);
  return true;
}

}  // namespace furnace
