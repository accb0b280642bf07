#include "server/file_body.hpp"

#include <algorithm>

#include <unistd.h>

namespace furnace {

std::string FileBody::read(std::size_t offset, std::size_t size) const {
  constexpr std::size_t kPieceBytes = 64 << 10;
  std::string piece(std::min(size, kPieceBytes), '\0');
  const ssize_t got = ::pread(file.get(), piece.data(), piece.size(), static_cast<off_t>(offset));
  piece.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return piece;
}

}  // namespace furnace
