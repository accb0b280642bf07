// Equirect map -> square octahedral tile.
#pragma once

#include <vector>

#include "renderer/base/worker_pool.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// Four floats that are computed together: RGB and a spare.
struct Quad {
  typedef float Vector __attribute__((vector_size(16)));
  Vector v = {};
};

// Fills tiles one after the other; its buffers are kept from one to the next.
// Threads: one caller; works on the pool. Owns: its buffers.
class TileResampler {
 public:
  explicit TileResampler(WorkerPool& pool) : pool_(pool) {}

  // The map at the centres of inner x inner texels (inner even), adjusted so that bilinear reading between them has the
  // least error in the mean square. Row by row; valid until the next call.
  const std::vector<Quad>& resample(const Image& equirect, int inner);

 private:
  void pad(const Image& equirect);
  void sample_all(int inner);
  void sharpen(int inner);

  WorkerPool& pool_;
  int width_ = 0;   // of the equirect, px
  int height_ = 0;  // px
  std::vector<Quad> padded_;
  std::vector<Quad> sampled_;
  std::vector<Quad> tile_;
};

// The texel that stands at (i, j) when the tile is continued by one texel beyond its edges: an edge meets its own mirror
// image, corners meet opposite corners.
struct TexelIndex {
  int i = 0;
  int j = 0;
};
TexelIndex fold_octahedral(int i, int j, int inner);

}  // namespace furnace
