// The KTX 2.0 container: what its header, indices and metadata say, checked against the file's size.
#pragma once

#include "renderer/image/decode.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace furnace {

enum class Ktx2Scheme : std::uint32_t { kNone, kBasisLz, kZstandard, kZlib };

// Khronos Data Format: color models and transfer functions.
inline constexpr std::uint8_t kDfModelEtc1s = 163, kDfModelUastc = 166;
inline constexpr std::uint8_t kDfTransferLinear = 1, kDfTransferSrgb = 2;

struct Ktx2Level {
  Extent extent;
  std::span<const std::byte> bytes;  // as stored
};

// Of a two-dimensional texture. Owns: nothing, the file must outlive it.
struct Ktx2 {
  std::uint32_t vk_format = 0;  // VkFormat; 0 for Basis Universal
  Ktx2Scheme scheme = Ktx2Scheme::kNone;
  std::vector<Ktx2Level> levels;  // the largest first, at least one
  std::uint8_t model = 0, transfer = 0;
  bool premultiplied = false;
  std::vector<std::uint8_t> channels;               // ids of the descriptor's samples
  std::span<const std::byte> global_data;           // of BasisLZ
  std::array<char, 4> swizzle{'r', 'g', 'b', 'a'};  // what each channel shows: one of "rgba01"
  bool right_to_left = false, bottom_up = false;
};

// Errors: kUnsupportedMedia for cube maps, arrays, volumes and unknown schemes, kTooLarge for the area,
// kUnprocessable for what is damaged.
Ktx2 open_ktx2(std::span<const std::byte> file, const DecodeLimits& limits);

// Little-endian. The place must be within the bytes.
std::uint16_t read_u16(std::span<const std::byte> bytes, std::size_t at);
std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at);

}  // namespace furnace
