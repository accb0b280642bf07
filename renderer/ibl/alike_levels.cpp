#include "renderer/ibl/alike_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "renderer/ibl/zonal_kernel.hpp"

namespace furnace {

namespace {

constexpr int kMostWholes = 4;
constexpr int kBandStep = 8;     // of the search for the first degree of a tail
constexpr int kManyBands = 256;  // a kernel with more is kept for the others
// So many times what single precision rounds off a level is still less than what is cut off.
constexpr double kLargestFactor = 100;

using Vector = std::array<double, kMostWholes>;
using Matrix = std::array<Vector, kMostWholes>;

// x of a x = b, for a symmetric and positive a (Cholesky); nothing where rounding makes it singular.
std::optional<Vector> solve(Matrix a, Vector b, int size) {
  for (int i = 0; i < size; ++i) {
    const double diagonal = a[i][i];
    for (int j = 0; j <= i; ++j) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      if (j < i) a[i][j] /= a[j][j];
    }
    if (a[i][i] <= 1e-12 * diagonal) return std::nullopt;
    a[i][i] = std::sqrt(a[i][i]);
    for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (int i = size - 1; i >= 0; --i) {
    for (int k = i + 1; k < size; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  return b;
}

// Order k columns +- b as order b: at the centres of the texels (i + 0.5) / columns they are the same but for the sign (-1)^k.
RowSpectrum sampled(const RowSpectrum& spectrum, int columns) {
  const int orders = std::min(spectrum.orders(), columns / 2 + 1);
  constexpr StoredLanes kConjugate = {{1, -1, 1, -1, 1, -1, 1, -1}};
  RowSpectrum folded(spectrum.rows(), orders);
  for (int j = 0; j < spectrum.rows(); ++j) {
    const StoredLanes* from = spectrum.row(j);
    StoredLanes* to = folded.row(j);
    std::copy_n(from, orders, to);
    for (int m = orders; m < spectrum.orders(); ++m) {
      const int k = (m + columns / 2 - 1) / columns, b = m - k * columns;
      const StoredLanes::Vector signed_value = (k % 2 == 0 ? 1.0f : -1.0f) * from[m].v;
      if (b >= 0) to[b].v += signed_value;
      if (b <= 0) to[-b].v += kConjugate.v * signed_value;
    }
  }
  return folded;
}

}  // namespace

AlikeLevels::Tail AlikeLevels::tail_of(const std::vector<double>& kernel, double cut_off) const {
  const int count = static_cast<int>(wholes_.size()), bands = static_cast<int>(kernel.size());
  Tail best{bands, std::vector<double>(count, 0.0)};
  Matrix products = {};  // of the wholes above a degree, weighted with 2 l + 1
  Vector with_kernel = {};
  double square = 0;
  for (int l = bands - 1; l >= 0; --l) {
    const double weight = 2 * l + 1;
    square += weight * kernel[l] * kernel[l];
    for (int i = 0; i < count; ++i) {
      with_kernel[i] += weight * kernel[l] * wholes_[i].kernel[l];
      for (int j = 0; j <= i; ++j) products[i][j] += weight * wholes_[i].kernel[l] * wholes_[j].kernel[l];
    }
    if (l % kBandStep != 0 || l == 0) continue;
    Vector factors = {};
    double left = square;
    if (const std::optional<Vector> solved = solve(products, with_kernel, count)) {
      factors = *solved;
      for (int i = 0; i < count; ++i) left -= factors[i] * with_kernel[i];
    }
    if (left > cut_off * cut_off) break;
    const auto too_large = [](double factor) { return std::abs(factor) > kLargestFactor; };
    if (std::any_of(factors.begin(), factors.end(), too_large)) continue;
    best.bands = l;
    std::copy_n(factors.begin(), count, best.factors.begin());
  }
  return best;
}

RowSpectrum AlikeLevels::synthesise_rest(std::vector<double> kernel, const Tail& tail, BakeWork& work) const {
  kernel.resize(tail.bands);
  int orders = tail.bands;
  for (std::size_t i = 0; i < wholes_.size(); ++i) {
    for (int l = 0; l < tail.bands; ++l) kernel[l] -= tail.factors[i] * wholes_[i].kernel[l];
    orders = std::max(orders, wholes_[i].spectrum.orders());
  }
  const RowSpectrum rest = sampled(synthesise(coefficients_, table_, kernel, rows_, work), 2 * rows_);
  RowSpectrum sum(rows_, orders);
  for (int j = 0; j < rows_; ++j) {
    StoredLanes* to = sum.row(j);
    std::fill(std::copy_n(rest.row(j), rest.orders(), to), to + orders, StoredLanes{});
    for (std::size_t i = 0; i < wholes_.size(); ++i) {
      const StoredLanes* from = wholes_[i].spectrum.row(j);
      const auto factor = static_cast<float>(tail.factors[i]);
      const int count = wholes_[i].spectrum.orders();
      in_widest_registers([=]() __attribute__((always_inline)) {
        for (int m = 0; m < count; ++m) to[m].v += factor * from[m].v;
      });
    }
  }
  return sum;
}

Image AlikeLevels::level(std::vector<double> kernel, double cut_off, BakeWork& work) {
  const Tail tail = tail_of(kernel, cut_off);
  const int own_bands = sufficient_bands(kernel, cut_off);
  if (2 * tail.bands <= own_bands)
    return equirect_of_spectrum(synthesise_rest(std::move(kernel), tail, work), 2 * rows_, work);
  const bool is_kept = own_bands > kManyBands && wholes_.size() < kMostWholes;
  // What is cut off a kept one counts as often as the others take of it.
  std::vector<double> enough = kernel;
  if (!is_kept) enough.resize(own_bands);
  RowSpectrum spectrum = sampled(synthesise(coefficients_, table_, enough, rows_, work), 2 * rows_);
  Image equirect = equirect_of_spectrum(spectrum, 2 * rows_, work);
  if (is_kept) wholes_.push_back({std::move(kernel), std::move(spectrum)});
  return equirect;
}

}  // namespace furnace
