// The GGX kernel between two rows of the sphere, in closed form for every Fourier order.
#pragma once

#include <vector>

#include "renderer/ibl/lanes.hpp"

namespace furnace {

// Order m of mu / (t + beta)^2 as a function of the azimuth between a point of row theta and one of row theta', with
// t = (1 - mu) / 2: q^m (constant + slope m), m >= 0. On two rows t + beta = a - b cos(phi) with
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
// Threads: a value.
struct CoreSeries {
  double q = 0;
  double constant = 0;
  double slope = 0;

  // As many orders at least as count for something beside a series that is e^above of this one.
  double reach(double log_above) const;
};

// Sixteen orders of a series: in single precision, as the rows that it weighs are.
struct alignas(64) Orders {
  typedef float Vector __attribute__((vector_size(64)));

  static constexpr int kCount = 16;
  static int blocks(int orders) { return (orders + kCount - 1) / kCount; }

  Vector v = {};
};

struct RowDistance {
  RowDistance(double theta, double source_theta);

  double minus = 0;  // sin^2((theta - theta') / 2)
  double plus = 0;   // sin^2((theta + theta') / 2)
};
CoreSeries core_series(double beta, const RowDistance& rows, double factor);

// out[m / 16][m % 16] += order m, for `blocks` blocks.
void add_series(const CoreSeries& series, int blocks, Orders* out);

// Sampled at the centres of `width` texels, orders k width +- m look like order m.
// Threads: any, immutable. Owns: tables of weights.
class Folding {
 public:
  Folding(int width, int blocks);  // even width, blocks of orders up to width / 2

  int width() const { return width_; }
  int blocks() const { return blocks_; }
  // The mean of order k width + m or k width - m over a texel's width relative to that of order m, by blocks.
  const Orders* above(int k) const { return weights_.data() + std::size_t(2 * k - 2) * blocks_; }
  const Orders* below(int k) const { return weights_.data() + std::size_t(2 * k - 1) * blocks_; }

  static constexpr int kMost = 4;  // k

 private:
  int width_ = 0;
  int blocks_ = 0;
  std::vector<Orders> weights_;
};

// out += the folded orders, weighted so that a later factor sinc(m / width) makes of each its own mean over a texel.
void add_folded(const CoreSeries& series, const Folding& folding, Orders* out);

}  // namespace furnace
