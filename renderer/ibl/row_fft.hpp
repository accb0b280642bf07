// Rows of an equirect map <-> their Fourier coefficients.
#pragma once

#include <array>
#include <vector>

#include "renderer/ibl/lane_fft.hpp"

namespace furnace {

// Eight rows of the north and their eight mirror images in the south at a time: each pair of real rows shares one complex
// transform, each lane holds one pair. A null pointer is a row that is not there.
// Threads: const members any, each with its own scratch. Owns: the transform's tables.
class RowFft {
 public:
  static constexpr int kPairs = 8;

  template <class T>
  struct Rows {
    std::array<T*, kPairs> north{};
    std::array<T*, kPairs> south{};
  };

  struct Scratch {
    std::vector<Lanes> re, im, work;
  };

  explicit RowFft(int width);

  // RGB texels -> c_m for m <= width / 2: f(phi) = sum over m of c_m e^(i m phi), c_-m = conj(c_m), phi from the left edge
  // of the map; exact for texels that are constant over their width.
  void spectra_of_texels(const Rows<const float>& texels, const Rows<Lanes>& spectra, Scratch& scratch) const;

  // Samples at the texel centres, every order of the spectra; below 0 becomes 0.
  void texels_of_spectra(const Rows<const Lanes>& spectra, int orders, const Rows<float>& texels,
                         Scratch& scratch) const;

 private:
  void prepare(Scratch& scratch) const;

  int width_ = 0;
  LaneFft fft_;
  std::vector<double> box_cos_, box_sin_;        // mean over a texel, e^(-i pi m / width), 1 / width
  std::vector<double> centre_cos_, centre_sin_;  // e^(i pi m / width)
};

}  // namespace furnace
