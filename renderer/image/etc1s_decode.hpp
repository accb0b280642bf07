// Basis Universal's ETC1S: blocks of 4 x 4 texels by two codebooks, compressed as KTX 2.0's BasisLZ has it.
#pragma once

#include "renderer/image/basis_bits.hpp"
#include "renderer/image/image.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace furnace {

// What all slices of a file share. Threads: immutable once built.
class Etc1sCodebooks {
 public:
  struct Slice {
    std::uint32_t offset = 0, size = 0;  // within its level; size 0: none
  };
  struct Picture {
    Slice color, alpha;
  };

  // `global_data`: of BasisLZ, for `levels` pictures. Errors: kUnprocessable, kUnsupportedMedia for video.
  Etc1sCodebooks(std::span<const std::byte> global_data, std::size_t levels);

  const std::vector<Picture>& pictures() const { return pictures_; }
  // RGB of the texels of `extent`, rows one after another, 3 bytes each. Errors: kUnprocessable.
  std::vector<std::uint8_t> decode(std::span<const std::byte> slice, Extent extent) const;

 private:
  struct Endpoint {
    std::array<std::uint8_t, 3> color{};  // 5 bits
    std::uint8_t table = 0;               // of intensities
  };
  using Selector = std::array<std::uint8_t, 4>;  // a byte a row, two bits a texel from the left

  void read_endpoints(std::span<const std::byte> bytes);
  void read_selectors(std::span<const std::byte> bytes);
  void read_tables(std::span<const std::byte> bytes);
  void paint(const Endpoint& endpoint, const Selector& selector, Extent extent, int block_x, int block_y,
             std::vector<std::uint8_t>& rgb) const;

  std::vector<Picture> pictures_;
  std::vector<Endpoint> endpoints_;
  std::vector<Selector> selectors_;
  HuffmanTable prediction_code_, endpoint_code_, selector_code_, run_code_;
  std::uint32_t history_size_ = 0;
};

}  // namespace furnace
