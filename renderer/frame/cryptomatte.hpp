// Mattes by name: Friedman and Jones 2015, "Fully automatic ID mattes with support for motion blur and transparency", as the
// Cryptomatte specification 1.2.0 lays them out.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/image/encode.hpp"
#include "renderer/scene/film_layer.hpp"

namespace furnace {

// Appleby 2011, "MurmurHash3", x86_32.
std::uint32_t murmur3_32(std::string_view key, std::uint32_t seed = 0);

// The number that stands for a name: its hash as the bits of a float that is neither infinite, nor a NaN, nor denormal.
float matte_id(std::string_view name);

// The attributes of a file that holds the mattes `layer` of these things. Equal names share a matte.
std::vector<TextField> matte_attributes(std::string_view layer, std::span<const std::string> names);

// Who covers a tile's pixels, and how much of them. Threads: one. Owns: its counts.
class MatteTile {
 public:
  static constexpr std::size_t kRanks = 2 * kMatteLevels;
  struct Rank {
    float id = 0;     // matte_id(), which is never 0
    float cover = 0;  // (0, 1]
  };

  explicit MatteTile(Extent size);

  // One sub-frame of that weight. `keys`: of the draw that each sample sees, 0 for none; 2x2 samples a pixel, row by row.
  // `id_of_key`: its first is not used.
  void add(std::span<const std::uint32_t> keys, std::span<const float> id_of_key, float weight);
  // The largest of a pixel, largest first; those that are not there have no cover.
  std::array<Rank, kRanks> ranks(int x, int y) const;

 private:
  // More than are kept, so that the least of a crowded pixel are rarely missed; later ones are not counted.
  static constexpr std::size_t kSlots = 8;

  Extent size_;
  std::vector<std::array<Rank, kSlots>> pixels_;
};

}  // namespace furnace
