#include "renderer/ibl/core_series.hpp"

#include <algorithm>
#include <cmath>

namespace furnace {

namespace {

using Vector = Orders::Vector;

constexpr double kLogNegligible = 15;  // q^m below 3e-7 is dropped
constexpr Vector kIndices = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

// weight * q^(start + i) (constant + slope * order), order = first, first + direction, ...
[[gnu::always_inline]] inline void add_powers(const Vector& first_power, float step,
                                              const Vector& first_order, float direction, float constant,
                                              float slope, const Orders* weight, int blocks, Orders* out) {
  Vector power = first_power, order = first_order;
  for (int b = 0; b < blocks; ++b) {
    const Vector term = power * (constant + slope * order);
    out[b].v += weight ? weight[b].v * term : term;
    power = step * power;
    order += Orders::kCount * direction;
  }
}

struct Powers {
  Vector first;  // 1, q, ..., q^15
  float step;    // q^16
};

Powers powers_of(double q) {
  const double q2 = q * q, q4 = q2 * q2, q8 = q4 * q4;
  const auto f1 = static_cast<float>(q), f2 = static_cast<float>(q2), f4 = static_cast<float>(q4),
             f8 = static_cast<float>(q8);
  const Vector a = {1, f1, 1, f1, 1, f1, 1, f1, 1, f1, 1, f1, 1, f1, 1, f1};
  const Vector b = {1, 1, f2, f2, 1, 1, f2, f2, 1, 1, f2, f2, 1, 1, f2, f2};
  const Vector c = {1, 1, 1, 1, f4, f4, f4, f4, 1, 1, 1, 1, f4, f4, f4, f4};
  const Vector d = {1, 1, 1, 1, 1, 1, 1, 1, f8, f8, f8, f8, f8, f8, f8, f8};
  return {(a * b) * (c * d), static_cast<float>(q8 * q8)};
}

}  // namespace

// -log q >= 1 - q, and nearly so where it matters.
double CoreSeries::reach(double log_above) const {
  return std::max(0.0, kLogNegligible - log_above) / (1 - q);
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

void add_series(const CoreSeries& series, int blocks, Orders* out) {
  const Powers powers = powers_of(series.q);
  const auto constant = static_cast<float>(series.constant), slope = static_cast<float>(series.slope);
  in_widest_registers([ =, &powers ]() __attribute__((always_inline)) {
    add_powers(powers.first, powers.step, kIndices, 1, constant, slope, nullptr, blocks, out);
  });
}

// The mean of e^(i m phi) over a texel is sinc(m / width), and sinc(k +- m / width) / sinc(m / width) = +-(-1)^k m / (k width +- m).
Folding::Folding(int width, int blocks)
    : width_(width), blocks_(blocks), weights_(std::size_t(2 * kMost) * blocks) {
  constexpr int n = Orders::kCount;
  for (int k = 1; k <= kMost; ++k) {
    const double sign = k % 2 == 0 ? 1 : -1;
    for (int m = 0; m < n * blocks; ++m) {
      weights_[std::size_t(2 * k - 2) * blocks + m / n].v[m % n] =
          static_cast<float>(sign * m / (double(k) * width + m));
      // Width / 2 is its own mirror image: counted once.
      weights_[std::size_t(2 * k - 1) * blocks + m / n].v[m % n] =
          2 * m < width ? static_cast<float>(-sign * m / (double(k) * width - m)) : 0;
    }
  }
}

void add_folded(const CoreSeries& series, const Folding& folding, Orders* out) {
  const double log_q = std::log(series.q);
  const int width = folding.width(), blocks = folding.blocks();
  const auto constant = static_cast<float>(series.constant), slope = static_cast<float>(series.slope);
  for (int k = 1; k <= Folding::kMost && -log_q * (k - 0.5) * width < kLogNegligible; ++k) {
    const auto start = static_cast<float>(std::exp(log_q * k * width));
    const Powers up = powers_of(series.q), down = powers_of(1 / series.q);
    const float first = static_cast<float>(k) * width;
    const Orders *above = folding.above(k), *below = folding.below(k);
    in_widest_registers([ =, &up, &down ]() __attribute__((always_inline)) {
      add_powers(start * up.first, up.step, first + kIndices, 1, constant, slope, above, blocks, out);
      add_powers(start * down.first, down.step, first - kIndices, -1, constant, slope, below, blocks, out);
    });
  }
}

}  // namespace furnace
