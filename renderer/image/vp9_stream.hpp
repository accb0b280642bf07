// VP9 by libvpx: planes in, coded frames out. Same planes, same bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/image/image.hpp"

namespace furnace {

// Y'CbCr 4:2:0 of 8 bits, rows tightly packed; the chroma planes have half the luma's sides, rounded up.
struct YuvPlanes {
  Extent extent;  // of luma, px
  std::vector<std::uint8_t> y, cb, cr;
};
inline Extent chroma_extent(Extent luma) {
  return {(luma.width + 1) / 2, (luma.height + 1) / 2};
}

struct Vp9Settings {
  int quality = 90;          // 1 to 100, the largest
  int frames_per_key = 120;  // from one frame that can be shown without another to the next, >= 1
  double frames_per_second = 24;
};

// In the order in which they are added; one a frame.
struct Vp9Frame {
  std::string bytes;
  bool is_key = false;
};

// Threads: one. Owns: the encoder, which holds back some frames. Errors: kInternal when it refuses.
class Vp9Stream {
 public:
  Vp9Stream(Extent extent, const Vp9Settings& settings);
  ~Vp9Stream();
  void add(const YuvPlanes& frame);  // of the extent
  std::vector<Vp9Frame> finish();    // once

 private:
  struct Encoder;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace furnace
