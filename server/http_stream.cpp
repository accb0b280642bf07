#include "server/http_stream.hpp"

#include <algorithm>
#include <string_view>

#include "server/negotiation.hpp"

namespace furnace {

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
  } while (in_fields_ && line_.ends_with('\n') &&
           media_type_essence(std::string_view(line_).substr(0, line_.find(':'))) == "range");
  in_fields_ = true;
  return !line_.empty();
}

}  // namespace furnace
