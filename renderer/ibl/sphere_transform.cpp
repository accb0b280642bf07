#include "renderer/ibl/sphere_transform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/base/check.hpp"
#include "renderer/ibl/scratch_pool.hpp"

namespace furnace {

namespace {

// For the pool's choice of chunks only.
constexpr double kGroupCost_us = 200;
constexpr double kOrderCost_us = 50;

// What one order contributes along a meridian, integrated over the height of each texel instead of sampled at its centre:
// the adjoint of 1 + d2/24 - 17 d4/5760 + 367 d6/967680, the central-difference series of the mean over a cell (Hildebrand
// 1974, "Introduction to Numerical Analysis"). The Legendre function times sin(theta) continues over a pole with the sign
// -(-1)^m, so the data do too. `column` has three free elements before and after its `rows`.
void integrate_cells(Lanes* column, int rows, int m, Lanes* out) {
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
  in_widest_registers([=]() __attribute__((always_inline)) {
    for (int j = 0; j < rows; ++j) {
      const Lanes* p = column + j;
      out[j] = c0 * p[0] + c1 * (p[-1] + p[1]) + c2 * (p[-2] + p[2]) + c3 * (p[-3] + p[3]);
    }
  });
}

// Neighbouring orders are taken together: the spectrum's rows are far apart in memory.
constexpr int kOrdersAtOnce = 4;

void analyse_orders(const RowSpectrum& spectrum, const LegendreTable& table,
                    const std::vector<RowBlock>& blocks, int first, int last,
                    HarmonicCoefficients& coefficients) {
  const int rows = spectrum.rows();
  std::vector<Lanes> padded(std::size_t(rows + 6) * kOrdersAtOnce), column(rows), scratch(2 * table.bands());
  for (int j = 0; j < rows; ++j)
    for (int m = first; m < last; ++m)
      padded[std::size_t(m - first) * (rows + 6) + j + 3] = spectrum.row(j)[m];

  for (int m = first; m < last; ++m) {
    integrate_cells(padded.data() + std::size_t(m - first) * (rows + 6) + 3, rows, m, column.data());
    const LegendreOrder legendre(table, m, table.bands());
    for (std::size_t b = legendre.first_block(blocks) / 2 * 2; b < blocks.size(); b += 2) {
      Lanes even[16] = {},
            odd[16] = {};  // rows that only fill up a block count as 0, not as whatever was there
      for (int i = 0; i < 16; ++i) {
        const int j = static_cast<int>(b) * 8 + i, mirror = rows - 1 - j;
        if (j > mirror) break;
        const double sin_theta = std::sin(std::numbers::pi * (j + 0.5) / rows);
        const double weight = 2 * std::numbers::pi * std::numbers::pi / rows * sin_theta;
        const Lanes south = mirror == j ? Lanes{} : column[mirror];
        even[i] = weight * (column[j] + south);
        odd[i] = weight * (column[j] - south);
      }
      legendre.add_to_degrees(blocks[b], blocks[b + 1], even, odd, coefficients.order(m), scratch.data());
    }
  }
}

// Planes of eight rows of the north -> the colours of rows j, j + 1, ... and of their mirror images.
void store_rows(const Lanes* even, const Lanes* odd, int j, int count, int m, RowSpectrum& spectrum) {
  Lanes north[8] = {}, south[8] = {};
  for (int c = 0; c < LegendreOrder::kPlanes; ++c) {
    north[c] = even[c] + odd[c];
    south[c] = even[c] - odd[c];
  }
  transpose(north);
  transpose(south);
  for (int i = 0; i < count; ++i) {
    spectrum.row(spectrum.rows() - 1 - j - i)[m] = south[i];
    spectrum.row(j + i)[m] = north[i];
  }
}

void synthesise_order(const HarmonicCoefficients& coefficients, const LegendreTable& table,
                      const std::vector<double>& kernel, const std::vector<RowBlock>& blocks, int m,
                      RowSpectrum& spectrum) {
  constexpr int n = LegendreOrder::kPlanes;
  const LegendreOrder legendre(table, m, static_cast<int>(kernel.size()));
  std::vector<double> scaled(std::size_t(legendre.degrees()) * n);
  const Lanes* source = coefficients.order(m);
  for (int k = 0; k < legendre.degrees(); ++k)
    for (int c = 0; c < n; ++c) scaled[k * n + c] = kernel[m + k] * source[k][c];

  const int rows = spectrum.rows();
  const std::size_t first = legendre.first_block(blocks) / 2 * 2;
  for (int j = 0; j < std::min<int>(static_cast<int>(first) * 8, (rows + 1) / 2); ++j)
    spectrum.row(j)[m] = spectrum.row(rows - 1 - j)[m] = Lanes{};
  for (std::size_t b = first; b < blocks.size(); b += 2) {
    Lanes even[2 * n], odd[2 * n];
    legendre.sum_degrees(blocks[b], blocks[b + 1], scaled.data(), even, odd);
    for (int half = 0; half < 2; ++half) {
      const int j = static_cast<int>(b + half) * 8;
      store_rows(even + half * n, odd + half * n, j, blocks[b + half].rows, m, spectrum);
    }
  }
}

}  // namespace

RowSpectrum::RowSpectrum(int rows, int orders)
    : rows_(rows),
      orders_(orders),
      values_(std::make_unique_for_overwrite<Lanes[]>(std::size_t(rows) * orders)) {}

HarmonicCoefficients::HarmonicCoefficients(int bands_)
    : bands(bands_), values(std::size_t(bands_) * (bands_ + 1) / 2) {}

RowSpectrum spectrum_of_equirect(const Image& equirect, WorkerPool& pool, int most,
                                 const Deadline& deadline) {
  const auto [width, rows] = equirect.extent;
  RowSpectrum spectrum(rows, std::min(most, width / 2 + 1));
  const RowFft fft(width);
  ScratchPool<RowFft::Scratch> scratches;
  const float* texels = equirect.samples<float>().data();
  pool.parallel_for(
      RowPairs<Lanes>::groups(rows), kGroupCost_us, [&, width = width, rows = rows](std::size_t group) {
        check_deadline(deadline, "environment: rows");
        ScratchPool<RowFft::Scratch>::Lease scratch(scratches);
        const int first = static_cast<int>(group) * RowPairs<Lanes>::kCount;
        fft.spectra_of_texels({first, rows, [&](int j) { return texels + std::size_t(j) * width * 3; }},
                              spectrum.orders(), {first, rows, [&](int j) { return spectrum.row(j); }},
                              *scratch);
      });
  return spectrum;
}

Image equirect_of_spectrum(const RowSpectrum& spectrum, int width, WorkerPool& pool) {
  const int rows = spectrum.rows();
  Image equirect = make_image({width, rows}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  const RowFft fft(width);
  ScratchPool<RowFft::Scratch> scratches;
  float* texels = equirect.samples<float>().data();
  pool.parallel_for(RowPairs<Lanes>::groups(rows), kGroupCost_us, [&](std::size_t group) {
    ScratchPool<RowFft::Scratch>::Lease scratch(scratches);
    const int first = static_cast<int>(group) * RowPairs<Lanes>::kCount;
    fft.texels_of_spectra({first, rows, [&](int j) { return spectrum.row(j); }}, spectrum.orders(),
                          {first, rows, [&](int j) { return texels + std::size_t(j) * width * 3; }},
                          *scratch);
  });
  return equirect;
}

HarmonicCoefficients analyse(const RowSpectrum& spectrum, const LegendreTable& table, WorkerPool& pool) {
  HarmonicCoefficients coefficients(table.bands());
  const std::vector<RowBlock> blocks = northern_blocks(spectrum.rows());
  const int orders = std::min(table.bands(), spectrum.orders());
  const int tasks = (orders + kOrdersAtOnce - 1) / kOrdersAtOnce;
  pool.parallel_for(tasks, kOrderCost_us * kOrdersAtOnce, [&](std::size_t task) {
    const int first = static_cast<int>(task) * kOrdersAtOnce;
    analyse_orders(spectrum, table, blocks, first, std::min(first + kOrdersAtOnce, orders), coefficients);
  });
  return coefficients;
}

RowSpectrum synthesise(const HarmonicCoefficients& coefficients, const LegendreTable& table,
                       const std::vector<double>& kernel, int rows, WorkerPool& pool) {
  FURNACE_CHECK(static_cast<int>(kernel.size()) <= coefficients.bands && coefficients.bands == table.bands(),
                "{} degrees of {}", kernel.size(), coefficients.bands);
  RowSpectrum spectrum(rows, static_cast<int>(kernel.size()));
  const std::vector<RowBlock> blocks = northern_blocks(rows);
  pool.parallel_for(kernel.size(), kOrderCost_us, [&](std::size_t m) {
    synthesise_order(coefficients, table, kernel, blocks, static_cast<int>(m), spectrum);
  });
  return spectrum;
}

}  // namespace furnace
