#include "renderer/ibl/sharp_level.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/ibl/quadrature.hpp"

namespace furnace {

// A kernel narrower than a few texels has more spherical degrees than it pays to transform. Far from its peak, however,
// it is the same function as that of a rougher level: scale * mu / (t + beta)^2 -> scale * mu / t^2. So
//
//   kernel = sum over k of d_k smooth_k  +  core,
//
// where the d_k extrapolate 1 / (t + beta)^2 by Lagrange's polynomial in beta from the smooth levels' beta_k to beta. The
// core falls like t^-(2 + count): it is summed over the rows within a few smooth widths only, in the Fourier domain of the
// rows, where it has a closed form. On two rows theta, theta' the chord is t + beta = a - b cos(phi) with
//
//   a = beta + (1 - cos theta cos theta') / 2,  b = sin theta sin theta' / 2,
//   s = sqrt(a^2 - b^2) = sqrt((beta + sin^2((theta - theta') / 2)) (beta + sin^2((theta + theta') / 2))),
//   q = b / (a + s),
//
// and, from 1 / (a - b cos phi) = sum over m of q^|m| e^(i m phi) / s and its derivative by a, with
// mu = 1 + 2 beta - 2 (t + beta),
//
//   | mu / (t + beta)^2 = sum over m of q^|m| ((1 + 2 beta) (a + |m| s) / s^3 - 2 / s) e^(i m phi) |
//
// The box of a texel is integrated over its width by the factor sinc(m / width), which `map` holds already, and over its
// height by Gauss's nodes. Orders beyond width / 2 matter while q^m is large: sampled at texel centres they fold onto m.

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kReach_alpha = 6.5;    // half height of the core in units of the sharpest smooth alpha
constexpr double kLogNegligible = 20;   // q^m below e^-20 is dropped
constexpr int kNearRows = 3;            // rows that need the finer rule over their height
constexpr int kNearNodes = 4;
constexpr double kGroupCost_us = 2000;

// Order m of mu / (t + beta)^2 on a pair of rows: q^m (constant + slope m).
struct Series {
  double q = 0;
  double constant = 0;
  double slope = 0;
};

Series series_of(double beta, double theta, double source, double weight) {
  const double minus = std::sin((theta - source) / 2), plus = std::sin((theta + source) / 2);
  const double low = beta + minus * minus, high = beta + plus * plus;
  const double a = 0.5 * (low + high), b = 0.5 * (high - low), s = std::sqrt(low * high);
  return {b / (a + s), weight * ((1 + 2 * beta) * a / (s * s * s) - 2 / s), weight * (1 + 2 * beta) / (s * s)};
}

[[gnu::always_inline]] inline Lanes first_powers(double q) {
  Lanes powers;
  double power = 1;
  for (int i = 0; i < 8; ++i, power *= q) powers.set(i, power);
  return powers;
}
[[gnu::always_inline]] inline double eighth_power(double q) {
  const double q2 = q * q, q4 = q2 * q2;
  return q4 * q4;
}
constexpr Lanes kCount = {{0, 1, 2, 3, 4, 5, 6, 7}};

// out[m / 8][m % 8] += order m
[[gnu::always_inline]] inline void add_series(Series series, int blocks, Lanes* out) {
  Lanes power = first_powers(series.q), m = kCount;
  const double step = eighth_power(series.q);
  for (int b = 0; b < blocks; ++b) {
    out[b] += power * (Lanes::all(series.constant) + series.slope * m);
    power = step * power;
    m += Lanes::all(8);
  }
}

// Orders k * width + m (up) and k * width - m (down), k > 0, as they fold onto m: divided by the sinc(m / width) that the
// map holds and multiplied by their own, that is by -+ (-1)^k m / (k width +- m).
[[gnu::always_inline]] inline void add_folded(Series series, double k_width, double start, double sign, bool down,
                                              int blocks, Lanes* out) {
  const double q = down ? 1 / series.q : series.q;
  const double direction = down ? -1 : 1;
  Lanes power = start * first_powers(q), m = kCount;
  const double step = eighth_power(q);
  for (int b = 0; b < blocks; ++b) {
    const Lanes order = Lanes::all(k_width) + direction * m;
    const Lanes ratio = {m.v / order.v};
    out[b] += sign * ratio * power * (Lanes::all(series.constant) + series.slope * order);
    power = step * power;
    m += Lanes::all(8);
  }
}

void add_folds(Series series, int width, int blocks, Lanes* out) {
  const double log_q = std::log(series.q);
  for (int k = 1; -log_q * (k - 0.5) * width < kLogNegligible; ++k) {
    const double k_width = double(k) * width, start = std::exp(log_q * k_width);
    const double sign = k % 2 == 0 ? 1 : -1;
    // Width / 2 is its own mirror image: counted once.
    const int nyquist = width / 2;
    const bool reached = nyquist / 8 < blocks;
    const double kept = reached ? out[nyquist / 8][nyquist % 8] : 0;
    in_widest_registers([=]() __attribute__((always_inline)) {
      add_folded(series, k_width, start, -sign, true, blocks, out);
    });
    if (reached) out[nyquist / 8].set(nyquist % 8, kept);
    in_widest_registers([=]() __attribute__((always_inline)) {
      add_folded(series, k_width, start, sign, false, blocks, out);
    });
  }
}

// kernel_l = sum over k of weight[l][k] smooth_k + scale_l (mu / (t + beta_l)^2 - sum of lagrange[l][k] mu / (t + beta_k)^2)
struct Extrapolation {
  std::vector<double> lagrange, weight;
};

std::vector<Extrapolation> extrapolate(const std::vector<GgxKernel>& kernels, const std::vector<SmoothLevel>& smooth) {
  std::vector<Extrapolation> all;
  for (const GgxKernel& kernel : kernels) {
    Extrapolation e;
    for (const SmoothLevel& level : smooth) {
      double lagrange = 1;
      for (const SmoothLevel& other : smooth) {
        if (&other == &level) continue;
        lagrange *= (kernel.beta() - other.kernel.beta()) / (level.kernel.beta() - other.kernel.beta());
      }
      e.lagrange.push_back(lagrange);
      e.weight.push_back(kernel.scale() * lagrange / level.kernel.scale());
    }
    all.push_back(std::move(e));
  }
  return all;
}

// The sums of all sharp levels on one row and its mirror image.
class CoreSum {
 public:
  CoreSum(const RowSpectrum& map, const std::vector<GgxKernel>& kernels, const std::vector<SmoothLevel>& smooth)
      : map_(map),
        kernels_(kernels),
        smooth_(smooth),
        extrapolations_(extrapolate(kernels, smooth)),
        cell_(kPi / map.rows),
        reach_(static_cast<int>(std::ceil(kReach_alpha * smooth.front().kernel.alpha() / cell_))),
        cell_nodes_(gauss_legendre(kNearNodes, -0.5 * cell_, 0.5 * cell_)) {}

  // The series of core_l on each row within reach, up to `used` orders.
  struct Scratch {
    std::vector<Lanes> sampled;     // at the rows' centres, [row][level][order / 8]
    std::vector<Lanes> integrated;  // over the rows' height, likewise
    std::vector<Lanes> smooth;      // of one row, [smooth level][order / 8]
    std::vector<int> used;          // per row
  };

  // Row i and its mirror image: adds to the orders of north[level], south[level].
  void convolve(int i, Lanes* const* north, Lanes* const* south, Scratch& scratch) const;

 private:
  int blocks() const { return (map_.orders + 7) / 8; }
  int width() const { return 2 * (map_.orders - 1); }
  std::size_t row_size() const { return kernels_.size() * blocks(); }
  void add_smooth_part(int row, Lanes* const* out) const;
  int used_orders(double theta, double source) const;
  void add_node(double theta, const QuadratureNode& source, int used, Lanes* out, Scratch& scratch) const;
  void fill_series(int i, int first, int last, Scratch& scratch) const;

  const RowSpectrum& map_;
  const std::vector<GgxKernel>& kernels_;
  const std::vector<SmoothLevel>& smooth_;
  std::vector<Extrapolation> extrapolations_;
  double cell_ = 0;
  int reach_ = 0;
  std::vector<QuadratureNode> cell_nodes_;
};

void CoreSum::add_smooth_part(int row, Lanes* const* out) const {
  for (std::size_t l = 0; l < kernels_.size(); ++l) {
    for (std::size_t k = 0; k < smooth_.size(); ++k) {
      const Lanes* in = smooth_[k].spectrum.row(row);
      Lanes* sum = out[l];
      const double weight = extrapolations_[l].weight[k];
      const int orders = std::min(smooth_[k].spectrum.orders, map_.orders);
      in_widest_registers([=]() __attribute__((always_inline)) {
        for (int m = 0; m < orders; ++m) sum[m] += weight * in[m];
      });
    }
  }
}

int CoreSum::used_orders(double theta, double source) const {
  const double decay = -std::log(series_of(kernels_.front().beta(), theta, source, 1).q);
  return static_cast<int>(std::min<double>(map_.orders, kLogNegligible / decay + 1));
}

// Adds the series of every core, taken at source.x, to out[level][order / 8].
void CoreSum::add_node(double theta, const QuadratureNode& source, int used, Lanes* out, Scratch& scratch) const {
  const int used_blocks = (used + 7) / 8;
  const double weight = 2 * kPi * source.weight * std::sin(source.x);
  const auto add = [&](double beta, double scale, Lanes* sum) {
    const Series series = series_of(beta, theta, source.x, weight * scale);
    in_widest_registers([=]() __attribute__((always_inline)) { add_series(series, used_blocks, sum); });
    if (used == map_.orders) add_folds(series, width(), used_blocks, sum);
  };
  for (std::size_t k = 0; k < smooth_.size(); ++k) {
    Lanes* sum = scratch.smooth.data() + k * blocks();
    std::fill_n(sum, used_blocks, Lanes{});
    add(smooth_[k].kernel.beta(), 1, sum);
  }
  for (std::size_t l = 0; l < kernels_.size(); ++l) {
    Lanes* sum = out + l * blocks();
    add(kernels_[l].beta(), kernels_[l].scale(), sum);
    for (std::size_t k = 0; k < smooth_.size(); ++k) {
      const Lanes* smooth = scratch.smooth.data() + k * blocks();
      const double factor = -kernels_[l].scale() * extrapolations_[l].lagrange[k];
      in_widest_registers([=]() __attribute__((always_inline)) {
        for (int b = 0; b < used_blocks; ++b) sum[b] += factor * smooth[b];
      });
    }
  }
}

// Rows close to i, and those at the poles, are integrated by Gauss's nodes; the others by the central difference of their
// neighbours' samples, f + d2 f / 24.
void CoreSum::fill_series(int i, int first, int last, Scratch& scratch) const {
  const double theta = (i + 0.5) * cell_;
  const std::size_t size = row_size();
  scratch.smooth.resize(smooth_.size() * blocks());
  scratch.sampled.assign((last - first + 1) * size, {});
  scratch.integrated.assign((last - first + 1) * size, {});
  scratch.used.resize(last - first + 1);
  for (int j = first; j <= last; ++j) {
    // One row nearer to i, where more orders matter: the difference needs them on both sides.
    const int nearer = j < i ? j + 1 : j > i ? j - 1 : j;
    const int used = used_orders(theta, (nearer + 0.5) * cell_);
    const double centre = (j + 0.5) * cell_;
    scratch.used[j - first] = used;
    if (std::abs(i - j) >= kNearRows)
      add_node(theta, {centre, cell_}, used, scratch.sampled.data() + (j - first) * size, scratch);
    if (std::abs(i - j) > kNearRows && j > 0 && j < map_.rows - 1) continue;
    for (const QuadratureNode& node : cell_nodes_)
      add_node(theta, {centre + node.x, node.weight}, used, scratch.integrated.data() + (j - first) * size, scratch);
  }
  for (int j = first; j <= last; ++j) {
    if (std::abs(i - j) <= kNearRows || j == 0 || j == map_.rows - 1) continue;
    const Lanes* here = scratch.sampled.data() + (j - first) * size;
    const Lanes* before = j > first ? here - size : here;  // beyond the reach there is nothing worth a difference
    const Lanes* after = j < last ? here + size : here;
    Lanes* out = scratch.integrated.data() + (j - first) * size;
    const int count = static_cast<int>(kernels_.size()), stride = blocks(), used_blocks = (scratch.used[j - first] + 7) / 8;
    in_widest_registers([=]() __attribute__((always_inline)) {
      for (int l = 0; l < count; ++l)
        for (int b = l * stride; b < l * stride + used_blocks; ++b)
          out[b] = (22.0 / 24) * here[b] + (1.0 / 24) * (before[b] + after[b]);
    });
  }
}

void CoreSum::convolve(int i, Lanes* const* north, Lanes* const* south, Scratch& scratch) const {
  constexpr int kTile = 32;  // orders whose sums stay in the first cache while the rows go by
  const int rows = map_.rows, first = std::max(0, i - reach_), last = std::min(rows - 1, i + reach_);
  add_smooth_part(i, north);
  add_smooth_part(rows - 1 - i, south);
  fill_series(i, first, last, scratch);
  for (int begin = 0; begin < map_.orders; begin += kTile) {
    for (int j = first; j <= last; ++j) {
      const int end = std::min(begin + kTile, scratch.used[j - first]);
      const Lanes *north_map = map_.row(j), *south_map = map_.row(rows - 1 - j);
      for (std::size_t l = 0; l < kernels_.size(); ++l) {
        const double* core =
            reinterpret_cast<const double*>(scratch.integrated.data() + (j - first) * row_size() + l * blocks());
        Lanes *north_sum = north[l], *south_sum = south[l];
        in_widest_registers([=]() __attribute__((always_inline)) {
          for (int m = begin; m < end; ++m) {
            north_sum[m] += core[m] * north_map[m];
            south_sum[m] += core[m] * south_map[m];
          }
        });
      }
    }
  }
}

}  // namespace

std::vector<Image> convolve_sharp(const RowSpectrum& map, const std::vector<GgxKernel>& kernels,
                                  const std::vector<SmoothLevel>& smooth, WorkerPool& pool) {
  const int rows = map.rows, orders = map.orders, width = 2 * (orders - 1);
  const int count = static_cast<int>(kernels.size());
  std::vector<Image> images;
  for (int l = 0; l < count; ++l)
    images.push_back(make_image({width, rows}, 3, SampleType::kFloat32, ColorSpace::kLinear));
  const CoreSum core(map, kernels, smooth);
  const RowFft fft(width);

  pool.parallel_for(pair_groups(rows), kGroupCost_us, [&](std::size_t group) {
    const int first = static_cast<int>(group) * RowFft::kPairs;
    // [level][pair][hemisphere][order]
    std::vector<Lanes> sums(std::size_t(count) * RowFft::kPairs * 2 * orders);
    const auto sum = [&](int level, int pair, int south) {
      return sums.data() + (std::size_t(level * RowFft::kPairs + pair) * 2 + south) * orders;
    };
    CoreSum::Scratch scratch;
    RowFft::Scratch fft_scratch;
    std::vector<Lanes*> north(count), south(count);
    for (int r = 0; r < RowFft::kPairs && first + r <= rows - 1 - first - r; ++r) {
      for (int l = 0; l < count; ++l) north[l] = sum(l, r, 0), south[l] = sum(l, r, 1);
      core.convolve(first + r, north.data(), south.data(), scratch);
    }
    for (int l = 0; l < count; ++l) {
      float* texels = images[l].samples<float>().data();
      RowFft::Rows<const Lanes> spectra;
      for (int r = 0; r < RowFft::kPairs; ++r) spectra.north[r] = sum(l, r, 0), spectra.south[r] = sum(l, r, 1);
      fft.texels_of_spectra(
          spectra, orders,
          row_pairs<float>(first, rows, [&](int j) { return texels + std::size_t(j) * width * 3; }), fft_scratch);
    }
  });
  return images;
}

}  // namespace furnace
