// OpenEXR's streams over memory. Included by the OpenEXR codecs alone.
#pragma once

#include <OpenEXR/ImfIO.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>

namespace furnace {

// A file in memory; what leaves it throws. Threads: one. Owns: nothing.
class ExrSource : public Imf::IStream {
 public:
  explicit ExrSource(std::span<const std::byte> file) : Imf::IStream("memory"), file_(file) {}

  bool read(char out[], int size) override {
    if (size < 0 || static_cast<std::uint64_t>(size) > file_.size() - position_) {
      throw std::runtime_error("it ends before its last pixel");
    }
    std::memcpy(out, file_.data() + position_, static_cast<std::size_t>(size));
    position_ += static_cast<std::size_t>(size);
    return position_ < file_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override {
    if (position > file_.size()) throw std::runtime_error("it points beyond its end");
    position_ = position;
  }

 private:
  std::span<const std::byte> file_;
  std::size_t position_ = 0;
};

// A file that grows in memory. Threads: one. Owns: its bytes.
class ExrSink : public Imf::OStream {
 public:
  explicit ExrSink(std::size_t expected_bytes) : Imf::OStream("memory") { bytes_.reserve(expected_bytes); }

  void write(const char bytes[], int size) override {
    const auto count = static_cast<std::size_t>(size);
    const std::size_t replaced = std::min(count, bytes_.size() - position_);
    bytes_.replace(position_, replaced, bytes, count);
    position_ += count;
  }
  std::uint64_t tellp() override { return position_; }
  // Only back, to fill in the tables of chunks.
  void seekp(std::uint64_t position) override {
    position_ = std::min<std::uint64_t>(position, bytes_.size());
  }

  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

}  // namespace furnace
