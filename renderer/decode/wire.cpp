#include "renderer/decode/wire.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>

namespace furnace::decode {
namespace {

// Arrays begin where any element may be read in place.
constexpr std::size_t kAlignment = 64;

std::size_t aligned(std::size_t offset) {
  return (offset + kAlignment - 1) / kAlignment * kAlignment;
}

bool read_at(int fd, std::span<std::byte> bytes, std::size_t offset) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(fd, bytes.data(), bytes.size(), off_t(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(std::size_t(got));
    offset += std::size_t(got);
  }
  return true;
}

}  // namespace

void WireWriter::text(const std::string& value, std::size_t most_bytes) {
  const std::size_t size = std::min(value.size(), most_bytes);
  number(std::uint32_t(size));
  append(value.data(), size);
}

void WireWriter::put_in_block(std::span<const std::byte> bytes) {
  const std::size_t begin = aligned(block_used_);
  fits_ = fits_ && begin <= block_.size() && bytes.size() <= block_.size() - begin;
  if (!fits_) return;
  std::ranges::copy(bytes, block_.begin() + std::ptrdiff_t(begin));
  block_used_ = begin + bytes.size();
}

const char* WireReader::take(std::size_t size) {
  sound_ = sound_ && size <= bytes_.size();
  if (!sound_) return nullptr;
  const char* from = bytes_.data();
  bytes_.remove_prefix(size);
  return from;
}

void WireReader::text(std::string& value, std::size_t most_bytes) {
  std::uint32_t size = 0;
  number(size);
  sound_ = sound_ && size <= most_bytes;
  const char* from = take(size);
  value = from ? std::string(from, size) : std::string();
}

std::size_t WireReader::array_count(std::size_t element_bytes) {
  std::uint64_t count = 0;
  number(count);
  const std::size_t begin = aligned(block_used_);
  sound_ = sound_ && begin <= block_bytes_ && count <= (block_bytes_ - begin) / element_bytes;
  return sound_ ? std::size_t(count) : 0;
}

// An environment has 100 MB: large pages come in a third of the time.
void WireReader::expect_large(std::span<std::byte> memory) {
  constexpr std::size_t kLargePage = 2 << 20;
  void* begin = memory.data();
  std::size_t bytes = memory.size();
  if (std::align(kLargePage, kLargePage, begin, bytes) != nullptr)
    ::madvise(begin, bytes / kLargePage * kLargePage, MADV_HUGEPAGE);
}

void WireReader::get_from_block(std::span<std::byte> bytes) {
  const std::size_t begin = aligned(block_used_);
  sound_ = sound_ && read_at(block_fd_, bytes, begin);
  block_used_ = begin + bytes.size();
}

}  // namespace furnace::decode
