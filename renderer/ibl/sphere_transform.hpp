// Equirect maps <-> Fourier rows <-> spherical-harmonic coefficients: computed in double precision, rows kept in
// single: what is rounded there is as random as the coefficients are many, and leaves less than 1e-7 of a row.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "renderer/ibl/bake_work.hpp"
#include "renderer/ibl/legendre.hpp"
#include "renderer/ibl/row_fft.hpp"
#include "renderer/image/image.hpp"

namespace furnace {

// The Fourier coefficients c_m of every row theta_j = pi (j + 0.5) / rows, as RowFft defines them: a colour in lanes.
// Threads: a value, moved only. Owns: its coefficients.
class RowSpectrum {
 public:
  RowSpectrum() = default;
  RowSpectrum(int rows, int orders);  // coefficients not set

  int rows() const { return rows_; }
  int orders() const { return orders_; }  // m in [0, orders)
  StoredLanes* row(int j) { return values_.get() + std::size_t(j) * orders_; }
  const StoredLanes* row(int j) const { return values_.get() + std::size_t(j) * orders_; }

 private:
  int rows_ = 0;
  int orders_ = 0;
  std::unique_ptr<StoredLanes[]> values_;
};

// a_lm for degrees l < bands: f = sum of a_lm p_lm(cos theta) e^(i m phi), with 2 pi * integral of p_lm^2 over [-1, 1] = 1.
// Threads: a value. Owns: its coefficients.
struct HarmonicCoefficients {
  explicit HarmonicCoefficients(int bands);

  // Degrees m, m + 1, ..., bands - 1 of one order: a colour in lanes.
  Lanes* order(int m) { return values.data() + offset(m); }
  const Lanes* order(int m) const { return values.data() + offset(m); }

  int bands = 0;
  std::vector<Lanes> values;

 private:
  std::size_t offset(int m) const { return std::size_t(m) * bands - std::size_t(m) * (m - 1) / 2; }
};

// Exact for a map that is constant over the width of each texel: orders 0 .. width / 2, or only the first `most`.
RowSpectrum spectrum_of_equirect(const Image& equirect, BakeWork& work,
                                 int most = std::numeric_limits<int>::max());

// The map sampled at texel centres, `width` to a row; orders above width / 2 are sampled too, not dropped.
Image equirect_of_spectrum(const RowSpectrum& spectrum, int width, BakeWork& work);

// Exact for a map that is constant over the height of each texel, for degrees up to about half of the rows, and good
// enough for the faint ones up to all rows. As many bands as the table has.
HarmonicCoefficients analyse(const RowSpectrum& spectrum, const LegendreTable& table, BakeWork& work);

// sum over l of a_lm kernel[l] p_lm(theta_j); the kernel's degrees take part, orders 0 .. kernel.size() - 1 come out.
RowSpectrum synthesise(const HarmonicCoefficients& coefficients, const LegendreTable& table,
                       const std::vector<double>& kernel, int rows, BakeWork& work);

}  // namespace furnace
