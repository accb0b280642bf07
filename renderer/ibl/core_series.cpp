#include "renderer/ibl/core_series.hpp"

#include <algorithm>
#include <cmath>

namespace furnace {

namespace {

constexpr double kLogNegligible = 20;  // q^m below e^-20 is dropped

// weight * q^(start + i) (constant + slope * order), order = first, first + direction, ...
[[gnu::always_inline]] inline void add_powers(Lanes power, double step, Lanes order, double direction,
                                              double constant, double slope, const Lanes* weight, int blocks,
                                              Lanes* out) {
  for (int b = 0; b < blocks; ++b) {
    const Lanes term = power * (Lanes::all(constant) + slope * order);
    out[b] += weight ? weight[b] * term : term;
    power = step * power;
    order += Lanes::all(8 * direction);
  }
}

struct Powers {
  Lanes first;    // 1, q, ..., q^7
  double eighth;  // q^8
};

Powers powers_of(double q) {
  Powers powers;
  double power = 1;
  for (int i = 0; i < 8; ++i, power *= q) powers.first.set(i, power);
  powers.eighth = power;
  return powers;
}

constexpr Lanes kCount = {{0, 1, 2, 3, 4, 5, 6, 7}};

}  // namespace

double CoreSeries::reach(double log_above) const {
  return std::max(0.0, kLogNegligible - log_above) / -std::log(q);
}

RowDistance::RowDistance(double theta, double source_theta)
    : minus(std::pow(std::sin((theta - source_theta) / 2), 2)),
      plus(std::pow(std::sin((theta + source_theta) / 2), 2)) {}

CoreSeries core_series(double beta, const RowDistance& rows, double factor) {
  const double low = beta + rows.minus, high = beta + rows.plus;
  const double a = 0.5 * (low + high), b = 0.5 * (high - low), s = std::sqrt(low * high);
  return {b / (a + s), factor * ((1 + 2 * beta) * a / (s * s * s) - 2 / s),
          factor * (1 + 2 * beta) / (s * s)};
}

void add_series(const CoreSeries& series, int blocks, Lanes* out) {
  const Powers powers = powers_of(series.q);
  in_widest_registers([ =, &powers, &series ]() __attribute__((always_inline)) {
    add_powers(powers.first, powers.eighth, kCount, 1, series.constant, series.slope, nullptr, blocks, out);
  });
}

// The mean of e^(i m phi) over a texel is sinc(m / width), and sinc(k +- m / width) / sinc(m / width) = +-(-1)^k m / (k width +- m).
Folding::Folding(int width, int blocks)
    : width_(width), blocks_(blocks), weights_(std::size_t(2 * kMost) * blocks) {
  for (int k = 1; k <= kMost; ++k) {
    const double sign = k % 2 == 0 ? 1 : -1;
    for (int m = 0; m < 8 * blocks; ++m) {
      weights_[std::size_t(2 * k - 2) * blocks + m / 8].set(m % 8, sign * m / (double(k) * width + m));
      // Width / 2 is its own mirror image: counted once.
      weights_[std::size_t(2 * k - 1) * blocks + m / 8].set(
          m % 8, 2 * m < width ? -sign * m / (double(k) * width - m) : 0);
    }
  }
}

void add_folded(const CoreSeries& series, const Folding& folding, Lanes* out) {
  const double log_q = std::log(series.q);
  const int width = folding.width(), blocks = folding.blocks();
  for (int k = 1; k <= Folding::kMost && -log_q * (k - 0.5) * width < kLogNegligible; ++k) {
    const double start = std::exp(log_q * k * width);
    const Powers up = powers_of(series.q), down = powers_of(1 / series.q);
    const Lanes first = Lanes::all(double(k) * width);
    const Lanes *above = folding.above(k), *below = folding.below(k);
    in_widest_registers([ =, &up, &down, &first, &series ]() __attribute__((always_inline)) {
      add_powers(start * up.first, up.eighth, first + kCount, 1, series.constant, series.slope, above, blocks,
                 out);
      add_powers(start * down.first, down.eighth, first - kCount, -1, series.constant, series.slope, below,
                 blocks, out);
    });
  }
}

}  // namespace furnace
