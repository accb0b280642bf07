// Equirect map -> square octahedral tile.
#pragma once

#include <cstddef>
#include <memory>

#include "renderer/base/worker_pool.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// Four floats that are computed together: RGB and a spare.
struct Quad {
  typedef float Vector __attribute__((vector_size(16)));
  Vector v;  // Quad{} is zero, plain Quad is not set
};

// A square of an RGBA kFloat16 image.
struct TileTexels {
  Image& image;
  int x = 0, y = 0;  // px, of its upper left texel
  int inner = 0;     // px, even
};

// Fills tiles one after the other; its buffers are kept from one to the next.
// Threads: one caller; works on the pool. Owns: its buffers.
class TileResampler {
 public:
  explicit TileResampler(WorkerPool& pool) : pool_(pool) {}

  // The map times `scale` at the centres of the tile's texels, adjusted so that bilinear reading between them has the least
  // error in the mean square; alpha 1.
  void resample(const Image& equirect, float scale, const TileTexels& tile);

 private:
  void sample_all(const Image& equirect, int inner);
  void sharpen(float scale, const TileTexels& tile);

  WorkerPool& pool_;
  std::unique_ptr<Quad[]> sampled_;  // row by row
  std::size_t capacity_ = 0;
};

// The texel that stands at (i, j) when the tile is continued by one texel beyond its edges: an edge meets its own mirror
// image, corners meet opposite corners.
struct TexelIndex {
  int i = 0;
  int j = 0;
};
TexelIndex fold_octahedral(int i, int j, int inner);

}  // namespace furnace
