#include "renderer/ibl/legendre.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace furnace {

namespace {

struct Recurrence {
  const double* step;
  const double* back;
  int degrees;
};

// Two blocks advance together: one alone would wait for its own results.
struct Walk {
  Lanes x_a, x_b, p_a, p_b, before_a, before_b;

  [[gnu::always_inline]] void advance(double step, double back) {
    const Lanes next_a = step * (x_a * p_a) - back * before_a;
    const Lanes next_b = step * (x_b * p_b) - back * before_b;
    before_a = p_a;
    before_b = p_b;
    p_a = next_a;
    p_b = next_b;
  }
};

[[gnu::always_inline]] inline void add_to_degrees_body(Recurrence r, Walk walk, const Lanes* even,
                                                       const Lanes* odd, Lanes* sums, Lanes* scratch) {
  for (int k = 0; k < r.degrees; ++k) {
    if (k > 0) walk.advance(r.step[k], r.back[k]);
    scratch[2 * k] = walk.p_a;
    scratch[2 * k + 1] = walk.p_b;
  }
  for (int parity = 0; parity < 2; ++parity) {
    const Lanes* rows = parity == 0 ? even : odd;
    for (int k = parity; k < r.degrees; k += 2) {
      const double* p = reinterpret_cast<const double*>(scratch + 2 * k);
      Lanes sum = sums[k];
      for (int i = 0; i < 16; ++i) sum += p[i] * rows[i];
      sums[k] = sum;
    }
  }
}

[[gnu::always_inline]] inline void sum_degrees_body(Recurrence r, Walk walk, const double* coefficients,
                                                    Lanes* even, Lanes* odd) {
  constexpr int n = LegendreOrder::kPlanes;
  Lanes even_sum[2 * n] = {}, odd_sum[2 * n] = {};
  for (int k = 0; k < r.degrees; k += 2) {
    if (k > 0) walk.advance(r.step[k], r.back[k]);
    for (int c = 0; c < n; ++c) {
      const double value = coefficients[k * n + c];
      even_sum[c] += value * walk.p_a;
      even_sum[n + c] += value * walk.p_b;
    }
    if (k + 1 == r.degrees) break;
    walk.advance(r.step[k + 1], r.back[k + 1]);
    for (int c = 0; c < n; ++c) {
      const double value = coefficients[(k + 1) * n + c];
      odd_sum[c] += value * walk.p_a;
      odd_sum[n + c] += value * walk.p_b;
    }
  }
  for (int c = 0; c < 2 * n; ++c) {
    even[c] = even_sum[c];
    odd[c] = odd_sum[c];
  }
}

}  // namespace

std::vector<RowBlock> northern_blocks(int rows) {
  const int north = (rows + 1) / 2;
  std::vector<RowBlock> blocks((north + 15) / 16 * 2);
  for (int j = 0; j < north; ++j) {
    const double theta = std::numbers::pi * (j + 0.5) / rows;
    RowBlock& block = blocks[j / 8];
    block.cos_theta.set(j % 8, std::cos(theta));
    block.log_sin_theta.set(j % 8, std::log(std::sin(theta)));
    block.largest_sin = std::sin(theta);
    block.rows = j % 8 + 1;
  }
  return blocks;
}

// Holmes and Featherstone 2002, "A unified approach to the Clenshaw summation and the recursive computation of very high
// degree and order normalised associated Legendre functions": the forward column recurrence.
LegendreTable::LegendreTable(int bands)
    : bands_(bands), step_(std::size_t(bands) * (bands + 1) / 2), back_(step_.size()), log_pmm_(bands) {
  double log_pmm = -0.5 * std::log(4 * std::numbers::pi);
  for (int m = 0; m < bands; ++m) {
    if (m > 0) log_pmm += 0.5 * std::log((2.0 * m + 1) / (2.0 * m));
    log_pmm_[m] = log_pmm;
    double *step = step_.data() + offset(m), *back = back_.data() + offset(m);
    for (int k = 1; k < bands - m; ++k) {
      const double l = m + k;
      step[k] = std::sqrt((4 * l * l - 1) / (l * l - double(m) * m));
      back[k] = k == 1 ? 0 : step[k] / step[k - 1];
    }
  }
}

// Debye's expansion of the Bessel function that p_lm resembles towards a pole: J_m(m sech a) ~ exp(-m (a - tanh a)).
bool LegendreOrder::negligible(const RowBlock& block) const {
  constexpr double kLogNegligible = 34;  // 2e-15
  const double reach = (m_ + degrees_) * block.largest_sin;
  if (block.rows == 0 || reach >= m_) return false;
  const double a = std::acosh(m_ / reach);
  return m_ * (a - std::tanh(a)) > kLogNegligible;
}

std::size_t LegendreOrder::first_block(const std::vector<RowBlock>& blocks) const {
  return std::partition_point(blocks.begin(), blocks.end(),
                              [&](const RowBlock& block) { return negligible(block); }) -
         blocks.begin();
}

Lanes LegendreOrder::first_degree(const RowBlock& block) const {
  Lanes pmm = {};
  for (int i = 0; i < block.rows; ++i) pmm.set(i, std::exp(table_.log_pmm(m_) + m_ * block.log_sin_theta[i]));
  return pmm;
}

void LegendreOrder::add_to_degrees(const RowBlock& a, const RowBlock& b, const Lanes* even, const Lanes* odd,
                                   Lanes* sums, Lanes* scratch) const {
  const Recurrence r{table_.step(m_), table_.back(m_), degrees_};
  const Walk walk{a.cos_theta, b.cos_theta, first_degree(a), first_degree(b), {}, {}};
  in_widest_registers([ =, &walk ]() __attribute__((always_inline)) {
    add_to_degrees_body(r, walk, even, odd, sums, scratch);
  });
}

void LegendreOrder::sum_degrees(const RowBlock& a, const RowBlock& b, const double* coefficients, Lanes* even,
                                Lanes* odd) const {
  const Recurrence r{table_.step(m_), table_.back(m_), degrees_};
  const Walk walk{a.cos_theta, b.cos_theta, first_degree(a), first_degree(b), {}, {}};
  in_widest_registers(
      [ =, &walk ]() __attribute__((always_inline)) { sum_degrees_body(r, walk, coefficients, even, odd); });
}

}  // namespace furnace
