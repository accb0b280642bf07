// The kernel between two rows theta, theta' of the sphere is, with z = kappa sin theta sin theta',
//
//   exp(kappa (mu - 1)) = exp(-kappa (1 - cos(theta - theta'))) exp(-z (1 - cos phi)),
//   | exp(-z (1 - cos phi)) = sum over m of e^-z I_m(z) e^(i m phi) |   (Abramowitz and Stegun 1964, 9.6.34)
//
// so every Fourier order of the rows is a sum over the rows within reach. The wider the kernel, the more rows but the
// fewer orders: the work is the same for every sigma, nothing is cut off that could ring, and no weight is negative.
#include "renderer/ibl/blur.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "renderer/base/check.hpp"
#include "renderer/ibl/quadrature.hpp"
#include "renderer/ibl/scratch_pool.hpp"
#include "renderer/ibl/sphere_transform.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLogNegligible = 26;  // the kernel below e^-26 of its peak is dropped
constexpr double kRowsPerSigma = 9;    // of the result: the cubic's error at four sigmas beside a sun
constexpr int kFewestRows = 64;
// In rows of the map. A narrower kernel blurs less than the texels do: what is left of it is mixed in, by its variance.
constexpr double kNarrowest = 0.4;
constexpr double kPairCost_us = 100;

// Debye's expansion of I_m(z) / I_0(z), its exponent bounded from below: after this many orders nothing is left.
int sufficient_orders(double z) {
  return static_cast<int>(std::ceil(std::sqrt(2 * kLogNegligible * z + 225))) + 1;
}

// out[m] += weight e^-z I_m(z) for m < orders, all lanes. The ratios r_m = I_m / I_(m-1) = z / (2 m + z r_(m+1)) are taken
// downwards, where that is stable, from an estimate between Amos's bounds (Amos 1974, "Computation of modified Bessel
// functions and their ratios"); e^z = I_0 + 2 (I_1 + I_2 + ...) scales them. `ratios`: as many.
void add_bessel(const Lanes& z, const Lanes& weight, int orders, Lanes* ratios, Lanes* out) {
  Lanes start;
  for (int k = 0; k < 8; ++k) start.set(k, z[k] / (orders + std::hypot(orders, z[k])));
  in_widest_registers([=]() __attribute__((always_inline)) {
    Lanes ratio = start, sum = {};
    for (int m = orders - 1; m > 0; --m) {
      ratio.v = z.v / (2.0 * m + z.v * ratio.v);
      ratios[m] = ratio;
      sum.v = ratio.v * (1 + sum.v);
    }
    Lanes term;
    term.v = weight.v / (1 + 2 * sum.v);
    out[0] += term;
    for (int m = 1; m < orders; ++m) {
      term = term * ratios[m];
      out[m] += term;
    }
  });
}

class Blur {
 public:
  Blur(const RowSpectrum& map, double sigma, int rows);

  struct Scratch {
    std::vector<Lanes> ratios, weights, north, south;
  };
  int orders() const { return orders_; }
  // Row i of the result and its mirror image.
  void convolve(int i, StoredLanes* north, StoredLanes* south, Scratch& scratch) const;

 private:
  // A line of constant theta within each row of the map.
  struct Line {
    double cos, sin, weight;  // weight: the azimuth's 2 pi times the kernel's scale and the rows' height
  };

  int set_weights(double theta, int first, Scratch& scratch) const;
  void fold(Lanes* weights, int orders) const;

  const RowSpectrum& map_;
  double sigma_ = 0;
  double kappa_ = 0;
  int rows_ = 0;
  int orders_ = 0;
  int nodes_ = 0;            // lines in a row
  std::vector<Line> lines_;  // [row][node]; rows that fill up the last eight weigh nothing
};

Blur::Blur(const RowSpectrum& map, double sigma, int rows)
    : map_(map),
      sigma_(sigma),
      kappa_(1 / (sigma * sigma)),
      rows_(rows),
      orders_(std::min(sufficient_orders(kappa_), map.orders())) {
  const double cell = kPi / map.rows();
  nodes_ = sigma > 4 * cell ? 2 : sigma > 1.5 * cell ? 3 : 6;
  const double scale = kappa_ / -std::expm1(-2 * kappa_);  // 2 pi times that of exp(kappa (mu - 1))
  const std::vector<QuadratureNode> nodes = gauss_legendre(nodes_, 0, cell);
  lines_.resize(std::size_t(map.rows() + 7) * nodes_, Line{0, 1, 0});
  for (int j = 0; j < map.rows(); ++j) {
    for (int n = 0; n < nodes_; ++n) {
      const double theta = j * cell + nodes[n].x, sin = std::sin(theta);
      lines_[std::size_t(j) * nodes_ + n] = {std::cos(theta), sin, scale * nodes[n].weight * sin};
    }
  }
}

// weights[m], lane k: what order m of the map's row first + k counts at theta. Returns how many orders there are.
int Blur::set_weights(double theta, int first, Scratch& scratch) const {
  const double cos = std::cos(theta), sin = std::sin(theta);
  const auto line = [&](int k, int n) -> const Line& { return lines_[std::size_t(first + k) * nodes_ + n]; };
  double largest = 0;
  for (int k = 0; k < 8; ++k)
    for (int n = 0; n < nodes_; ++n) largest = std::max(largest, kappa_ * sin * line(k, n).sin);
  const int orders = sufficient_orders(largest);
  scratch.ratios.resize(orders);
  scratch.weights.assign(orders, Lanes{});
  for (int n = 0; n < nodes_; ++n) {
    Lanes z, weight;
    for (int k = 0; k < 8; ++k) {
      const Line& source = line(k, n);
      z.set(k, kappa_ * sin * source.sin);
      weight.set(k,
                 source.weight * std::exp(std::min(0.0, kappa_ * (cos * source.cos + sin * source.sin - 1))));
    }
    add_bessel(z, weight, orders, scratch.ratios.data(), scratch.weights.data());
  }
  if (orders <= map_.orders()) return std::min(orders, orders_);
  fold(scratch.weights.data(), orders);
  return map_.orders();
}

// At the centres of `width` texels, orders k width +- m look like order m; of the map, which is constant over texels,
// they are sinc(k +- m / width) / sinc(m / width) = +-(-1)^k m / (k width +- m) of it, and the signs of e^(i m phi) at the
// centres undo those.
void Blur::fold(Lanes* weights, int orders) const {
  const int width = 2 * (map_.orders() - 1);
  for (int n = map_.orders(); n < orders; ++n) {
    const int bin = n % width, m = std::min(bin, width - bin);
    const bool odd = n / width % 2 == 1;  // k of k width + m; k - 1 of k width - m
    weights[m] += ((odd ? -1.0 : 1.0) * m / n) * weights[n];
  }
}

void Blur::convolve(int i, StoredLanes* north_out, StoredLanes* south_out, Scratch& scratch) const {
  const int rows = map_.rows();
  const double theta = kPi * (i + 0.5) / rows_, cell = kPi / rows;
  // kappa (1 - cos) > kLogNegligible
  const double reach = 2 * std::asin(std::min(1.0, sigma_ * std::sqrt(kLogNegligible / 2)));
  const int first = std::max(0, static_cast<int>((theta - reach) / cell));
  const int last = std::min(rows - 1, static_cast<int>((theta + reach) / cell));
  scratch.north.assign(orders_, Lanes{});
  scratch.south.assign(orders_, Lanes{});
  Lanes *north = scratch.north.data(), *south = scratch.south.data();
  for (int begin = first; begin <= last; begin += 8) {
    const int orders = set_weights(theta, begin, scratch);
    const StoredLanes *from[8], *mirrored[8];
    for (int k = 0; k < 8; ++k) {
      const int j = std::min(begin + k, rows - 1);
      from[k] = map_.row(j);
      mirrored[k] = map_.row(rows - 1 - j);
    }
    const double* weights = reinterpret_cast<const double*>(scratch.weights.data());
    in_widest_registers([ =, &from, &mirrored ]() __attribute__((always_inline)) {
      for (int m = 0; m < orders; ++m) {
        Lanes north_sum = north[m], south_sum = south[m];
        for (int k = 0; k < 8; ++k) {
          north_sum += weights[8 * m + k] * from[k][m].widen();
          south_sum += weights[8 * m + k] * mirrored[k][m].widen();
        }
        north[m] = north_sum;
        south[m] = south_sum;
      }
    });
  }
  store(north, orders_, north_out);
  store(south, orders_, south_out);
}

int result_rows(double sigma, int map_rows) {
  const double wanted = std::max<double>(kFewestRows, kRowsPerSigma * kPi / sigma);
  for (int rows = kFewestRows; rows < map_rows; rows *= 2) {
    for (int fine : {rows, rows / 2 * 3})  // lengths that the Fourier transform likes
      if (fine >= wanted && fine < map_rows) return fine;
  }
  return map_rows;
}

Image convolve(const Image& radiance, double sigma, BakeWork& work) {
  const auto [width, height] = radiance.extent;
  const int orders = std::min(sufficient_orders(1 / (sigma * sigma)), width / 2 + 1);
  const RowSpectrum map = spectrum_of_equirect(radiance, work, orders);
  const int rows = result_rows(sigma, height);
  const Blur blur(map, sigma, rows);
  RowSpectrum blurred(rows, blur.orders());
  ScratchPool<Blur::Scratch> scratches;
  work.parallel_for((rows + 1) / 2, kPairCost_us, [&](std::size_t i) {
    ScratchPool<Blur::Scratch>::Lease scratch(scratches);
    blur.convolve(int(i), blurred.row(int(i)), blurred.row(rows - 1 - int(i)), *scratch);
  });
  return equirect_of_spectrum(blurred, rows == height ? width : 2 * rows, work);
}

}  // namespace

Image blurred_environment(const Image& radiance, double sigma_rad, WorkerPool& pool,
                          const Deadline& deadline) {
  FURNACE_CHECK(sigma_rad >= 0 && sigma_rad <= kPi, "sigma {}", sigma_rad);
  const double narrowest = kNarrowest * kPi / radiance.extent.height;
  const double share = std::min(1.0, std::pow(sigma_rad / narrowest, 2));
  if (share == 0) return radiance;
  BakeWork work(pool, deadline);
  Image blurred = convolve(radiance, std::max(sigma_rad, narrowest), work);
  if (share == 1) return blurred;
  const auto from = radiance.samples<float>();
  const auto to = blurred.samples<float>();
  for (std::size_t k = 0; k < to.size(); ++k)
    to[k] = static_cast<float>(from[k] + share * (double{to[k]} - from[k]));
  return blurred;
}

}  // namespace furnace
