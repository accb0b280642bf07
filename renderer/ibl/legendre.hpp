// Normalised associated Legendre functions on the rows of a map.
#pragma once

#include <vector>

#include "renderer/ibl/lanes.hpp"

namespace furnace {

// Rows theta_j = pi (j + 0.5) / rows of the northern half, eight to a block; the southern ones are their mirror images.
struct RowBlock {
  Lanes cos_theta = {};
  Lanes sin_theta = {};
  double largest_sin = 0;
  int rows = 0;  // of the eight lanes, 0 in a block that fills up the last pair
};
std::vector<RowBlock> northern_blocks(int rows);  // an even number of blocks

// The recurrence p_l = step x p_(l-1) - back p_(l-2) of every order.
// Threads: any, immutable. Owns: its coefficients.
class LegendreTable {
 public:
  explicit LegendreTable(int bands);

  int bands() const { return bands_; }
  // Of l = m, m + 1, ..., bands - 1.
  const double* step(int m) const { return step_.data() + offset(m); }
  const double* back(int m) const { return back_.data() + offset(m); }
  double log_pmm(int m) const { return log_pmm_[m]; }  // of p_mm at the equator
  // p_mm / p_(m-1)(m-1) = grow(m) sin(theta), m > 0
  double grow(int m) const { return grow_[m]; }
  // p_lm is negligible where l sin(theta) is less.
  double least_reach(int m) const { return least_reach_[m]; }

 private:
  std::size_t offset(int m) const { return std::size_t(m) * bands_ - std::size_t(m) * (m - 1) / 2; }

  int bands_ = 0;
  std::vector<double> step_, back_, log_pmm_, grow_, least_reach_;
};

// p_mm on all blocks, for one order after the other.
// Threads: one. Owns: its values; table and blocks must outlive it.
class FirstDegrees {
 public:
  FirstDegrees(const LegendreTable& table, const std::vector<RowBlock>& blocks, int m);

  void next_order();
  int order() const { return m_; }
  const Lanes& on(std::size_t block) const { return values_[block]; }
  const LegendreTable& table() const { return table_; }
  const std::vector<RowBlock>& blocks() const { return blocks_; }

 private:
  const LegendreTable& table_;
  const std::vector<RowBlock>& blocks_;
  int m_ = 0;
  std::vector<Lanes> values_;
};

// p_lm(cos theta) for one order m and degrees m <= l < bands, normalised so that 2 pi * integral of p^2 over [-1, 1] = 1.
// Colours come as six planes: R.re R.im G.re G.im B.re B.im. "Even" and "odd" are the parity of l - m, which is that of
// p_lm over the equator. Blocks are taken by pairs, the first one even.
// Threads: any, immutable. Owns: nothing; what it was made of must stay as it is.
class LegendreOrder {
 public:
  static constexpr int kPlanes = 6;

  LegendreOrder(const FirstDegrees& first, int bands)
      : first_(first), m_(first.order()), degrees_(bands - m_) {}

  int degrees() const { return degrees_; }

  // The first pair in which some p_lm is not negligible.
  std::size_t first_pair() const;

  // sums[l - m] (a colour in lanes) += sum over the rows r of both blocks of p_lm(r) * (l - m even ? even : odd)[r].
  // even, odd: sixteen colours. `scratch`: 2 * degrees().
  void add_to_degrees(std::size_t pair, const Lanes* even, const Lanes* odd, Lanes* sums,
                      Lanes* scratch) const;

  // even[plane], odd[plane] (rows in lanes; planes of the first block, then of the second) = sum over even, odd l - m of
  // p_lm * coefficients[l - m][plane].
  void sum_degrees(std::size_t pair, const Lanes* coefficients, Lanes* even, Lanes* odd) const;

 private:
  int negligible_degrees(std::size_t pair) const;

  const FirstDegrees& first_;
  int m_ = 0;
  int degrees_ = 0;
};

}  // namespace furnace
