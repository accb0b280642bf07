#include "renderer/base/blob.hpp"

#include "renderer/base/check.hpp"

#include <utility>

namespace furnace {

Blob::Blob(std::string bytes) {
  auto owner = std::make_shared<const std::string>(std::move(bytes));
  bytes_ = std::as_bytes(std::span(*owner));
  owner_ = std::move(owner);
  hash_ = hash_bytes(bytes_);
}

Blob Blob::slice(const Blob& whole, std::size_t offset, std::size_t size) {
  FURNACE_CHECK(offset <= whole.size() && size <= whole.size() - offset, "bytes {} + {} of {}", offset, size,
                whole.size());
  Blob part;
  part.owner_ = whole.owner_;
  part.bytes_ = whole.bytes_.subspan(offset, size);
  part.hash_ = hash_bytes(part.bytes_);
  return part;
}

}  // namespace furnace
