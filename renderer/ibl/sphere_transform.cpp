#include "renderer/ibl/sphere_transform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/base/check.hpp"
#include "renderer/ibl/scratch_pool.hpp"

namespace furnace {

namespace {

// For the pool's choice of chunks only.
constexpr double kTexelCost_us = 0.2;  // times sixteen rows
constexpr double kOrderCost_us = 50;

// What one order contributes along a meridian, integrated over the height of each texel instead of sampled at its centre:
// the adjoint of 1 + d2/24 - 17 d4/5760 + 367 d6/967680, the central-difference series of the mean over a cell (Hildebrand
// 1974, "Introduction to Numerical Analysis"). The Legendre function times sin(theta) continues over a pole with the sign
// -(-1)^m, so the data do too. `column` has three free elements before and after its `rows`.
void integrate_cells(Lanes* column, int rows, int m, const std::vector<double>& sin_theta, Lanes* out) {
  constexpr double kD2 = 1.0 / 24, kD4 = -17.0 / 5760, kD6 = 367.0 / 967680;
  constexpr double c0 = 1 - 2 * kD2 + 6 * kD4 - 20 * kD6;
  constexpr double c1 = kD2 - 4 * kD4 + 15 * kD6;
  constexpr double c2 = kD4 - 6 * kD6;
  constexpr double c3 = kD6;
  const double sign = m % 2 == 0 ? -1 : 1;
  for (int k = 0; k < 3; ++k) {
    column[-1 - k] = sign * column[k];
    column[rows + k] = sign * column[rows - 1 - k];
  }
  const double* sine = sin_theta.data();
  in_widest_registers([=]() __attribute__((always_inline)) {
    for (int j = 0; j < rows; ++j) {
      const Lanes* p = column + j;
      out[j] = sine[j] * (c0 * p[0] + c1 * (p[-1] + p[1]) + c2 * (p[-2] + p[2]) + c3 * (p[-3] + p[3]));
    }
  });
}

// Neighbouring orders are taken together: the spectrum's rows are far apart in memory.
constexpr int kOrdersAtOnce = 8;

// A map has more rows than the table's degrees ask for: what they weigh is handed over to fewer, by the adjoint of
// Lagrange's interpolation of the Legendre functions between these. With two rows a degree the functions it is worst for are
// the faintest by far of all kernels.
class FewerRows {
 public:
  FewerRows(int rows, int bands) : rows_(rows), fewer_(rows >= 4 * bands ? 2 * bands : rows) {
    if (fewer_ == rows_) return;
    for (int j = 0; j < rows; ++j) {
      const double x = (j + 0.5) * fewer_ / rows - 0.5, cell = std::floor(x);
      Share share{static_cast<int>(cell) - kNodes / 2 + 1, {}};
      for (int k = 0; k < kNodes; ++k) {
        share.weight[k] = 1;
        for (int other = 0; other < kNodes; ++other) {
          if (other != k) share.weight[k] *= (x - (share.first + other)) / (k - other);
        }
      }
      shares_.push_back(share);
    }
  }

  int rows() const { return fewer_; }

  // column: weighted values of order m, at least rows() of them -> the same on rows(). `padded`: rows() + 2 kNodes.
  void hand_over(Lanes* column, int m, Lanes* padded) const {
    if (fewer_ == rows_) return;
    std::fill_n(padded, fewer_ + 2 * kNodes, Lanes{});
    const int rows = rows_;
    const Share* shares = shares_.data();
    in_widest_registers([=]() __attribute__((always_inline)) {
      for (int j = 0; j < rows; ++j) {
        Lanes* to = padded + kNodes + shares[j].first;
        for (int k = 0; k < kNodes; ++k) to[k] += shares[j].weight[k] * column[j];
      }
    });
    std::copy_n(padded + kNodes, fewer_, column);
    const double sign = m % 2 == 0 ? 1 : -1;  // of a Legendre function over a pole
    for (int k = 0; k < kNodes; ++k) {
      column[k] += sign * padded[kNodes - 1 - k];
      column[fewer_ - 1 - k] += sign * padded[kNodes + fewer_ + k];
    }
  }

  static constexpr int kNodes = 8;

 private:
  struct Share {
    int first = 0;
    double weight[kNodes] = {};
  };

  int rows_ = 0;
  int fewer_ = 0;
  std::vector<Share> shares_;
};

struct AnalysisScratch {
  std::vector<Lanes> padded, column, margins, degrees;
};

void analyse_orders(const RowSpectrum& spectrum, const LegendreTable& table, const FewerRows& fewer,
                    const std::vector<RowBlock>& blocks, const std::vector<double>& sin_theta, int first,
                    int last, HarmonicCoefficients& coefficients, AnalysisScratch& scratch) {
  const int rows = spectrum.rows(), fewer_rows = fewer.rows();
  scratch.padded.resize(std::size_t(rows + 6) * kOrdersAtOnce);
  scratch.column.resize(rows);
  scratch.margins.resize(fewer_rows + 2 * FewerRows::kNodes);
  scratch.degrees.resize(2 * table.bands());
  Lanes *padded = scratch.padded.data(), *column = scratch.column.data();
  const double weight = 2 * std::numbers::pi * std::numbers::pi / rows;
  in_widest_registers([&]() __attribute__((always_inline)) {
    for (int j = 0; j < rows; ++j) {
      const StoredLanes* row = spectrum.row(j);
      for (int m = first; m < last; ++m)
        padded[std::size_t(m - first) * (rows + 6) + j + 3] = weight * row[m].widen();
    }
  });

  FirstDegrees sectoral(table, blocks, first);
  for (int m = first; m < last; ++m) {
    if (m > first) sectoral.next_order();
    integrate_cells(padded + std::size_t(m - first) * (rows + 6) + 3, rows, m, sin_theta, column);
    fewer.hand_over(column, m, scratch.margins.data());
    const LegendreOrder legendre(sectoral, table.bands());
    for (std::size_t b = legendre.first_pair(); b < blocks.size(); b += 2) {
      // Rows that only fill up a block count as 0, not as whatever was there.
      Lanes even[16] = {}, odd[16] = {};
      const int begin = static_cast<int>(b) * 8;
      in_widest_registers([&]() __attribute__((always_inline)) {
        for (int i = 0; i < 16; ++i) {
          const int j = begin + i, mirror = fewer_rows - 1 - j;
          if (j > mirror) break;
          const Lanes south = mirror == j ? Lanes{} : column[mirror];
          even[i] = column[j] + south;
          odd[i] = column[j] - south;
        }
      });
      legendre.add_to_degrees(b, even, odd, coefficients.order(m), scratch.degrees.data());
    }
  }
}

// Planes of eight rows of the north -> the colours of rows j, j + 1, ... of `orders` orders, and of their mirror images.
[[gnu::always_inline]] inline void store_rows(const Lanes* even, const Lanes* odd, int j, int count, int rows,
                                              StoredLanes* column) {
  Lanes north[8] = {}, south[8] = {};
  for (int c = 0; c < LegendreOrder::kPlanes; ++c) {
    north[c] = even[c] + odd[c];
    south[c] = even[c] - odd[c];
  }
  transpose(north);
  transpose(south);
  for (int i = 0; i < count; ++i) {
    column[std::size_t(rows - 1 - j - i) * kOrdersAtOnce] = StoredLanes::of(south[i]);
    column[std::size_t(j + i) * kOrdersAtOnce] = StoredLanes::of(north[i]);
  }
}

struct SynthesisScratch {
  std::vector<Lanes> scaled;
  std::vector<StoredLanes> columns;
};

// column: of row 0; that of the next row is kOrdersAtOnce further on.
void synthesise_order(const HarmonicCoefficients& coefficients, const FirstDegrees& sectoral,
                      const std::vector<double>& kernel, int rows, Lanes* scaled, StoredLanes* column) {
  constexpr int n = LegendreOrder::kPlanes;
  const LegendreOrder legendre(sectoral, static_cast<int>(kernel.size()));
  const int degrees = legendre.degrees();
  const Lanes* source = coefficients.order(sectoral.order());
  const double* factors = kernel.data() + sectoral.order();
  in_widest_registers([=]() __attribute__((always_inline)) {
    for (int k = 0; k < degrees; ++k) scaled[k] = factors[k] * source[k];
  });

  const std::vector<RowBlock>& blocks = sectoral.blocks();
  const std::size_t first = legendre.first_pair();
  for (int j = 0; j < std::min<int>(static_cast<int>(first) * 8, (rows + 1) / 2); ++j)
    column[std::size_t(j) * kOrdersAtOnce] = column[std::size_t(rows - 1 - j) * kOrdersAtOnce] =
        StoredLanes{};
  for (std::size_t b = first; b < blocks.size(); b += 2) {
    Lanes even[2 * n], odd[2 * n];
    legendre.sum_degrees(b, scaled, even, odd);
    const int j = static_cast<int>(b) * 8, upper = blocks[b].rows, lower = blocks[b + 1].rows;
    in_widest_registers([ =, &even, &odd ]() __attribute__((always_inline)) {
      store_rows(even, odd, j, upper, rows, column);
      store_rows(even + n, odd + n, j + 8, lower, rows, column);
    });
  }
}

}  // namespace

RowSpectrum::RowSpectrum(int rows, int orders)
    : rows_(rows),
      orders_(orders),
      values_(std::make_unique_for_overwrite<StoredLanes[]>(std::size_t(rows) * orders)) {}

HarmonicCoefficients::HarmonicCoefficients(int bands_)
    : bands(bands_), values(std::size_t(bands_) * (bands_ + 1) / 2) {}

RowSpectrum spectrum_of_equirect(const Image& equirect, BakeWork& work, int most) {
  const auto [width, rows] = equirect.extent;
  RowSpectrum spectrum(rows, std::min(most, width / 2 + 1));
  const RowFft fft(width);
  ScratchPool<RowFft::Scratch> scratches;
  const float* texels = equirect.samples<float>().data();
  work.parallel_for(RowPairs<StoredLanes>::groups(rows), kTexelCost_us * width,
                    [&, width = width, rows = rows](std::size_t group) {
                      ScratchPool<RowFft::Scratch>::Lease scratch(scratches);
                      const int first = static_cast<int>(group) * RowPairs<StoredLanes>::kCount;
                      fft.spectra_of_texels(
                          {first, rows, [&](int j) { return texels + std::size_t(j) * width * 3; }},
                          spectrum.orders(), {first, rows, [&](int j) { return spectrum.row(j); }}, *scratch);
                    });
  return spectrum;
}

Image equirect_of_spectrum(const RowSpectrum& spectrum, int width, BakeWork& work) {
  const int rows = spectrum.rows();
  Image equirect = make_image({width, rows}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  const RowFft fft(width);
  ScratchPool<RowFft::Scratch> scratches;
  float* texels = equirect.samples<float>().data();
  work.parallel_for(RowPairs<StoredLanes>::groups(rows), kTexelCost_us * width, [&](std::size_t group) {
    ScratchPool<RowFft::Scratch>::Lease scratch(scratches);
    const int first = static_cast<int>(group) * RowPairs<StoredLanes>::kCount;
    fft.texels_of_spectra({first, rows, [&](int j) { return spectrum.row(j); }}, spectrum.orders(),
                          {first, rows, [&](int j) { return texels + std::size_t(j) * width * 3; }},
                          *scratch);
  });
  return equirect;
}

HarmonicCoefficients analyse(const RowSpectrum& spectrum, const LegendreTable& table, BakeWork& work) {
  HarmonicCoefficients coefficients(table.bands());
  const FewerRows fewer(spectrum.rows(), table.bands());
  const std::vector<RowBlock> blocks = northern_blocks(fewer.rows());
  const int orders = std::min(table.bands(), spectrum.orders());
  const int tasks = (orders + kOrdersAtOnce - 1) / kOrdersAtOnce;
  std::vector<double> sin_theta;
  for (int j = 0; j < spectrum.rows(); ++j)
    sin_theta.push_back(std::sin(std::numbers::pi * (j + 0.5) / spectrum.rows()));
  ScratchPool<AnalysisScratch> scratches;
  work.parallel_for(tasks, kOrderCost_us * kOrdersAtOnce, [&](std::size_t task) {
    ScratchPool<AnalysisScratch>::Lease scratch(scratches);
    const int first = static_cast<int>(task) * kOrdersAtOnce;
    analyse_orders(spectrum, table, fewer, blocks, sin_theta, first, std::min(first + kOrdersAtOnce, orders),
                   coefficients, *scratch);
  });
  return coefficients;
}

RowSpectrum synthesise(const HarmonicCoefficients& coefficients, const LegendreTable& table,
                       const std::vector<double>& kernel, int rows, BakeWork& work) {
  FURNACE_CHECK(static_cast<int>(kernel.size()) <= coefficients.bands && coefficients.bands == table.bands(),
                "{} degrees of {}", kernel.size(), coefficients.bands);
  const int orders = static_cast<int>(kernel.size());
  RowSpectrum spectrum(rows, orders);
  const std::vector<RowBlock> blocks = northern_blocks(rows);
  const int tasks = (orders + kOrdersAtOnce - 1) / kOrdersAtOnce;
  ScratchPool<SynthesisScratch> scratches;
  work.parallel_for(tasks, kOrderCost_us * kOrdersAtOnce, [&](std::size_t task) {
    const int first = static_cast<int>(task) * kOrdersAtOnce, last = std::min(first + kOrdersAtOnce, orders);
    ScratchPool<SynthesisScratch>::Lease scratch(scratches);
    scratch->scaled.resize(orders);
    scratch->columns.resize(std::size_t(rows) * kOrdersAtOnce);
    FirstDegrees sectoral(table, blocks, first);
    for (int m = first; m < last; ++m) {
      if (m > first) sectoral.next_order();
      synthesise_order(coefficients, sectoral, kernel, rows, scratch->scaled.data(),
                       scratch->columns.data() + (m - first));
    }
    for (int j = 0; j < rows; ++j)
      std::copy_n(scratch->columns.data() + std::size_t(j) * kOrdersAtOnce, last - first,
                  spectrum.row(j) + first);
  });
  return spectrum;
}

}  // namespace furnace
