// Levels of one grid whose kernels have a kink at the horizon.
#pragma once

#include <vector>

#include "renderer/ibl/sphere_transform.hpp"

namespace furnace {

// A kink makes k_l fall like l^-5/2 only, so hundreds of degrees count, but it is the same kink in every kernel: above some
// dozens of degrees each kernel is a sum of a few others. Those few are synthesised with all of their degrees, the others
// with the first ones of what is left of them.
// Threads: one caller; works on the pool. Owns: the spectra of those few; coefficients and table must outlive it.
class AlikeLevels {
 public:
  AlikeLevels(const HarmonicCoefficients& coefficients, const LegendreTable& table, int rows)
      : coefficients_(coefficients), table_(table), rows_(rows) {}

  int rows() const { return rows_; }

  // The convolution with a kernel, k_l for all of the table's degrees, less what is below `cut_off` as in sufficient_bands.
  // Sampled at the texel centres of an equirect with twice as many columns as rows.
  Image level(std::vector<double> kernel, double cut_off, BakeWork& work);

 private:
  struct Whole {
    std::vector<double> kernel;
    RowSpectrum spectrum;
  };
  // kernel = sum of factors[i] * wholes_[i] above so many degrees.
  struct Tail {
    int bands = 0;
    std::vector<double> factors;
  };

  Tail tail_of(const std::vector<double>& kernel, double cut_off) const;
  RowSpectrum synthesise_rest(std::vector<double> kernel, const Tail& tail, BakeWork& work) const;

  const HarmonicCoefficients& coefficients_;
  const LegendreTable& table_;
  int rows_ = 0;
  std::vector<Whole> wholes_;
};

}  // namespace furnace
