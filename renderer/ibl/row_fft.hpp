// Rows of an equirect map <-> their Fourier coefficients.
#pragma once

#include <algorithm>
#include <vector>

#include "renderer/ibl/lane_fft.hpp"

namespace furnace {

// Eight rows of the north and their mirror images in the south, which are transformed together.
template <class T>
struct RowPairs {
  static constexpr int kCount = 8;

  // Pairs first, first + 1, ... of a map of `rows` rows, the last one repeated when they run out; row(j) gives a row's
  // first element. A row on the equator is its own mirror image.
  template <class RowOf>
  RowPairs(int first, int rows, RowOf&& row) {
    for (int r = 0; r < kCount; ++r) {
      const int j = std::min(first + r, (rows - 1) / 2);
      north[r] = row(j);
      south[r] = row(rows - 1 - j);
    }
  }

  // How many groups of pairs a map has.
  static int groups(int rows) { return ((rows + 1) / 2 + kCount - 1) / kCount; }

  T* north[kCount];
  T* south[kCount];
};

// Each pair of real rows shares one complex transform, each lane holds one pair.
// Threads: const members any, each with its own scratch. Owns: the transform's tables.
class RowFft {
 public:
  struct Scratch {
    std::vector<ComplexLanes> planes[3], work;
  };

  explicit RowFft(int width);

  // RGB texels -> c_m for m < orders <= width / 2 + 1: f(phi) = sum over m of c_m e^(i m phi), c_-m = conj(c_m), phi from the left edge
  // of the map; exact for texels that are constant over their width. Sets all lanes.
  void spectra_of_texels(const RowPairs<const float>& texels, int orders,
                         const RowPairs<StoredLanes>& spectra, Scratch& scratch) const;

  // Samples at the texel centres, every order of the spectra; below 0 becomes 0.
  void texels_of_spectra(const RowPairs<const StoredLanes>& spectra, int orders,
                         const RowPairs<float>& texels, Scratch& scratch) const;

 private:
  void prepare(Scratch& scratch) const;

  int width_ = 0;
  LaneFft fft_;
  std::vector<double> box_cos_, box_sin_;        // mean over a texel, e^(-i pi m / width), 1 / width
  std::vector<double> centre_cos_, centre_sin_;  // e^(i pi m / width)
};

}  // namespace furnace
