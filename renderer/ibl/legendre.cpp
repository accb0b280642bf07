#include "renderer/ibl/legendre.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace furnace {

namespace {

constexpr double kLogNegligible = 24;  // 4e-11

struct Recurrence {
  const double* step;
  const double* back;
  int negligible;  // degrees that count for nothing, even
  int degrees;
};

// Some rows of a pair of blocks, in `kCount` vectors that advance together: one alone would wait for its own results.
template <class Vector, int kCount>
struct Walk {
  static constexpr int kRows = kCount * int(sizeof(Vector) / sizeof(double));

  Vector x[kCount], p[kCount], before[kCount];

  // The rows from `row` on.
  [[gnu::always_inline]] void begin(const Lanes* cosines, const Lanes* first, int row) {
    __builtin_memcpy(x, reinterpret_cast<const double*>(cosines) + row, sizeof(x));
    __builtin_memcpy(p, reinterpret_cast<const double*>(first) + row, sizeof(p));
    __builtin_memset(before, 0, sizeof(before));
  }

  [[gnu::always_inline]] void advance(double step, double back) {
    for (int i = 0; i < kCount; ++i) {
      const Vector next = (step * x[i]) * p[i] - back * before[i];
      before[i] = p[i];
      p[i] = next;
    }
  }

  [[gnu::always_inline]] void pass_over(const Recurrence& r) {
    for (int k = 1; k <= r.negligible; ++k) advance(r.step[k], r.back[k]);
  }
};

// A pair of blocks: cosines, p_mm.
struct Rows {
  Lanes cosines[2], first[2];
};

template <class Vector, int kCount>
[[gnu::always_inline]] inline void walk_degrees(const Recurrence& r, const Rows& rows, Lanes* degrees) {
  for (int row = 0; row < 16; row += Walk<Vector, kCount>::kRows) {
    Walk<Vector, kCount> walk;
    walk.begin(rows.cosines, rows.first, row);
    walk.pass_over(r);
    for (int k = r.negligible; k < r.degrees; ++k) {
      if (k > r.negligible) walk.advance(r.step[k], r.back[k]);
      __builtin_memcpy(reinterpret_cast<double*>(degrees + 2 * k) + row, walk.p, sizeof(walk.p));
    }
  }
}

[[gnu::always_inline]] inline void add_to_degrees_body(const Recurrence& r, const Lanes* even,
                                                       const Lanes* odd, Lanes* sums, const Lanes* degrees) {
  for (int parity = 0; parity < 2; ++parity) {
    const Lanes* rows = parity == 0 ? even : odd;
    for (int k = r.negligible + parity; k < r.degrees; k += 2) {
      const double* p = reinterpret_cast<const double*>(degrees + 2 * k);
      Lanes sum_a = sums[k], sum_b = p[8] * rows[8];
      for (int i = 0; i < 8; ++i) sum_a += p[i] * rows[i];
      for (int i = 9; i < 16; ++i) sum_b += p[i] * rows[i];
      sums[k] = sum_a + sum_b;
    }
  }
}

// Planes: of the first block's rows, then of the second's.
template <class Vector, int kCount>
[[gnu::always_inline]] inline void sum_degrees_body(const Recurrence& r, const Rows& rows,
                                                    const Lanes* coefficients, Lanes* even, Lanes* odd) {
  constexpr int n = LegendreOrder::kPlanes, kLanes = sizeof(Vector) / sizeof(double);
  const auto* planes = reinterpret_cast<const double*>(coefficients);
  for (int row = 0; row < 16; row += Walk<Vector, kCount>::kRows) {
    Walk<Vector, kCount> walk;
    walk.begin(rows.cosines, rows.first, row);
    Vector even_sum[kCount][n] = {}, odd_sum[kCount][n] = {};
    walk.pass_over(r);
    for (int k = r.negligible; k < r.degrees; k += 2) {
      if (k > r.negligible) walk.advance(r.step[k], r.back[k]);
      for (int c = 0; c < n; ++c)
        for (int i = 0; i < kCount; ++i) even_sum[i][c] += planes[k * 8 + c] * walk.p[i];
      if (k + 1 == r.degrees) break;
      walk.advance(r.step[k + 1], r.back[k + 1]);
      for (int c = 0; c < n; ++c)
        for (int i = 0; i < kCount; ++i) odd_sum[i][c] += planes[(k + 1) * 8 + c] * walk.p[i];
    }
    for (int i = 0; i < kCount; ++i) {
      const int at = row + i * kLanes, plane = at / 8 * n;
      for (int c = 0; c < n; ++c) {
        __builtin_memcpy(reinterpret_cast<double*>(even + plane + c) + at % 8, &even_sum[i][c],
                         sizeof(Vector));
        __builtin_memcpy(reinterpret_cast<double*>(odd + plane + c) + at % 8, &odd_sum[i][c], sizeof(Vector));
      }
    }
  }
}

// What fits the registers: a vector that is wider stays in memory, and many narrow ones do, too.
typedef double Two __attribute__((vector_size(16)));
typedef double Four __attribute__((vector_size(32)));
typedef Lanes::Vector Eight;

// Debye's expansion of the Bessel function that p_lm resembles towards a pole: J_m(m sech a) ~ exp(-m (a - tanh a)), for
// l sin(theta) = m sech a.
double least_reach(int m) {
  if (m == 0) return 0;
  const double wanted = kLogNegligible / m;
  double a = wanted + 1;
  for (int i = 0; i < 8; ++i) a -= (a - std::tanh(a) - wanted) / std::pow(std::tanh(a), 2);
  return m / std::cosh(a);
}

}  // namespace

std::vector<RowBlock> northern_blocks(int rows) {
  const int north = (rows + 1) / 2;
  std::vector<RowBlock> blocks((north + 15) / 16 * 2);
  for (int j = 0; j < north; ++j) {
    const double theta = std::numbers::pi * (j + 0.5) / rows;
    RowBlock& block = blocks[j / 8];
    block.cos_theta.set(j % 8, std::cos(theta));
    block.sin_theta.set(j % 8, std::sin(theta));
    block.largest_sin = std::sin(theta);
    block.rows = j % 8 + 1;
  }
  return blocks;
}

// Holmes and Featherstone 2002, "A unified approach to the Clenshaw summation and the recursive computation of very high
// degree and order normalised associated Legendre functions": the forward column recurrence.
LegendreTable::LegendreTable(int bands)
    : bands_(bands),
      step_(std::size_t(bands) * (bands + 1) / 2),
      back_(step_.size()),
      log_pmm_(bands),
      grow_(bands),
      least_reach_(bands) {
  double log_pmm = -0.5 * std::log(4 * std::numbers::pi);
  for (int m = 0; m < bands; ++m) {
    if (m > 0) grow_[m] = std::sqrt((2.0 * m + 1) / (2.0 * m));
    if (m > 0) log_pmm += std::log(grow_[m]);
    log_pmm_[m] = log_pmm;
    least_reach_[m] = furnace::least_reach(m);
    double *step = step_.data() + offset(m), *back = back_.data() + offset(m);
    for (int k = 1; k < bands - m; ++k) {
      const double l = m + k;
      step[k] = std::sqrt((4 * l * l - 1) / (l * l - double(m) * m));
      back[k] = k == 1 ? 0 : step[k] / step[k - 1];
    }
  }
}

FirstDegrees::FirstDegrees(const LegendreTable& table, const std::vector<RowBlock>& blocks, int m)
    : table_(table), blocks_(blocks), m_(m), values_(blocks.size(), Lanes{}) {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (int i = 0; i < blocks[b].rows; ++i)
      values_[b].set(i, std::exp(table.log_pmm(m) + m * std::log(blocks[b].sin_theta[i])));
  }
}

void FirstDegrees::next_order() {
  const double grow = table_.grow(++m_);
  for (std::size_t b = 0; b < blocks_.size(); ++b) values_[b] = grow * (values_[b] * blocks_[b].sin_theta);
}

int LegendreOrder::negligible_degrees(std::size_t pair) const {
  const double sin = std::max(first_.blocks()[pair].largest_sin, first_.blocks()[pair + 1].largest_sin);
  const double degree = std::min<double>(first_.table().least_reach(m_) / sin, m_ + degrees_);
  return std::max(0, static_cast<int>(degree) - m_);
}

std::size_t LegendreOrder::first_pair() const {
  std::size_t pair = 0;
  while (pair < first_.blocks().size() && negligible_degrees(pair) == degrees_) pair += 2;
  return pair;
}

void LegendreOrder::add_to_degrees(std::size_t pair, const Lanes* even, const Lanes* odd, Lanes* sums,
                                   Lanes* scratch) const {
  const Recurrence r{first_.table().step(m_), first_.table().back(m_), negligible_degrees(pair) / 2 * 2,
                     degrees_};
  const Rows rows{{first_.blocks()[pair].cos_theta, first_.blocks()[pair + 1].cos_theta},
                  {first_.on(pair), first_.on(pair + 1)}};
  const int width = register_doubles();
  in_widest_registers([ =, &rows ]() __attribute__((always_inline)) {
    if (width == 8)
      walk_degrees<Eight, 2>(r, rows, scratch);
    else
      walk_degrees<Four, 2>(r, rows, scratch);
    add_to_degrees_body(r, even, odd, sums, scratch);
  });
}

void LegendreOrder::sum_degrees(std::size_t pair, const Lanes* coefficients, Lanes* even, Lanes* odd) const {
  const Recurrence r{first_.table().step(m_), first_.table().back(m_), negligible_degrees(pair) / 2 * 2,
                     degrees_};
  const Rows rows{{first_.blocks()[pair].cos_theta, first_.blocks()[pair + 1].cos_theta},
                  {first_.on(pair), first_.on(pair + 1)}};
  const int width = register_doubles();
  in_widest_registers([ =, &rows ]() __attribute__((always_inline)) {
    if (width == 8)
      sum_degrees_body<Eight, 2>(r, rows, coefficients, even, odd);
    else if (width == 4)
      sum_degrees_body<Four, 1>(r, rows, coefficients, even, odd);
    else
      sum_degrees_body<Two, 1>(r, rows, coefficients, even, odd);
  });
}

}  // namespace furnace
