#include "renderer/ibl/sharp_level.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "renderer/ibl/core_series.hpp"
#include "renderer/ibl/quadrature.hpp"
#include "renderer/ibl/scratch_pool.hpp"

namespace furnace {

// A kernel narrower than a few texels has more spherical degrees than it pays to transform. Far from its peak, however,
// it is the same function as that of a rougher level: scale * mu / (t + beta)^2 -> scale * mu / t^2. So
//
//   kernel = sum over k of d_k smooth_k  +  core,
//
// where the d_k extrapolate 1 / (t + beta)^2 by Lagrange's polynomial in beta from the smooth levels' beta_k to beta. The
// core falls like t^-(2 + count): it is summed over the rows within a few smooth widths only, in the Fourier domain of the
// rows, where it has a closed form (core_series.hpp). The box of a texel is integrated over its width by the factor
// sinc(m / width), which `map` holds already, and over its height by quadrature.

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kReach_alpha = 6.5;  // half height of the core in units of the sharpest smooth alpha
constexpr int kNearRows = 3;          // rows that need the finer rule over their height
constexpr int kNearNodes = 4;
constexpr int kTile = 64;  // orders whose sums stay in the first cache while the rows go by
constexpr int kRowsAtOnce = 4;
constexpr double kGroupCost_us = 2000;

// kernel_l = sum over k of weight[l][k] smooth_k + scale_l (mu / (t + beta_l)^2 - sum of lagrange[l][k] mu / (t + beta_k)^2)
struct Extrapolation {
  std::vector<double> lagrange, weight;
};

std::vector<Extrapolation> extrapolate(const std::vector<GgxKernel>& kernels,
                                       const std::vector<SmoothLevel>& smooth) {
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
  CoreSum(const RowSpectrum& map, const std::vector<GgxKernel>& kernels,
          const std::vector<SmoothLevel>& smooth)
      : map_(map),
        kernels_(kernels),
        smooth_(smooth),
        extrapolations_(extrapolate(kernels, smooth)),
        rows_(smooth.front().spectrum.rows()),
        cell_(kPi / map.rows()),
        reach_(static_cast<int>(std::ceil(kReach_alpha * smooth.front().kernel.alpha() / cell_))),
        folding_(width(), blocks()),
        cell_nodes_(gauss_legendre(kNearNodes, -0.5 * cell_, 0.5 * cell_)) {
    const double equator = 0.5 * kPi;
    for (const GgxKernel& kernel : kernels)
      orders_.push_back(
          std::max(used_orders(kernel.beta(), equator, equator), smooth.front().spectrum.orders()));
  }

  // The series of core_l on each row within reach, up to `used` orders.
  struct Scratch {
    std::vector<Orders> sampled;     // at the rows' centres, [row][level][order / 16]
    std::vector<Orders> integrated;  // over the rows' height, likewise
    std::vector<Orders> smooth;      // of one row, [smooth level][order / 16]
    std::vector<int> smooth_blocks;  // of each that are set
    std::vector<int> used;           // [row][level]
  };

  int rows() const { return rows_; }                      // of the result
  int orders(int level) const { return orders_[level]; }  // of the result
  // Row i and its mirror image: sets the orders of north[level], south[level].
  void convolve(int i, StoredLanes* const* north, StoredLanes* const* south, Scratch& scratch) const;

 private:
  // A line of constant theta within a row, seen from another.
  struct Source {
    RowDistance distance;
    double weight = 0;  // sr per radian of azimuth, times 2 pi
  };

  int levels() const { return static_cast<int>(kernels_.size()); }
  int blocks() const { return Orders::blocks(map_.orders()); }
  int width() const { return 2 * (map_.orders() - 1); }
  std::size_t row_size() const { return kernels_.size() * blocks(); }
  void set_smooth_part(int row, int level, int begin, int end, StoredLanes* out) const;
  int used_orders(double beta, double theta, double source) const;
  Source source_at(double theta, double source, double height) const;
  void sum_sources(std::span<const Source> sources, const int* used, Orders* out, Scratch& scratch) const;
  void fill_series(double theta, int first, int last, Scratch& scratch) const;
  void integrate_between(int j, int first, int last, Scratch& scratch) const;
  void even_out(Scratch& scratch) const;

  const RowSpectrum& map_;
  const std::vector<GgxKernel>& kernels_;
  const std::vector<SmoothLevel>& smooth_;
  std::vector<Extrapolation> extrapolations_;
  int rows_ = 0;
  double cell_ = 0;  // height of a row of the map, rad
  int reach_ = 0;
  Folding folding_;
  std::vector<QuadratureNode> cell_nodes_;
  std::vector<int> orders_;
};

void CoreSum::set_smooth_part(int row, int level, int begin, int end, StoredLanes* out) const {
  std::fill_n(out, end - begin, StoredLanes{});
  for (std::size_t k = 0; k < smooth_.size(); ++k) {
    const StoredLanes* in = smooth_[k].spectrum.row(row);
    const auto weight = static_cast<float>(extrapolations_[level].weight[k]);
    const int last = std::min(smooth_[k].spectrum.orders(), end);
    in_widest_registers([=]() __attribute__((always_inline)) {
      for (int m = begin; m < last; ++m) out[m - begin].v += weight * in[m].v;
    });
  }
}

int CoreSum::used_orders(double beta, double theta, double source) const {
  const RowDistance rows(theta, source);
  // The series begins with about (t + beta)^(-3/2): what is negligible beside that of theta's own row is so here.
  const double reach = core_series(beta, rows, 1).reach(1.5 * std::log1p(rows.minus / beta));
  return static_cast<int>(std::min<double>(map_.orders(), reach + 1));
}

CoreSum::Source CoreSum::source_at(double theta, double source, double height) const {
  return {RowDistance(theta, source), 2 * kPi * height * std::sin(source)};
}

// out[level][order / 16] = the series of every core, up to used[level] orders, summed over sources within one row.
void CoreSum::sum_sources(std::span<const Source> sources, const int* used, Orders* out,
                          Scratch& scratch) const {
  // Returns how many blocks it set.
  const auto sum_series = [&](double beta, double scale, int most, Orders* sum) {
    double reach = 0;
    for (const Source& source : sources)
      reach = std::max(reach, core_series(beta, source.distance, 1).reach(0));
    const int count = Orders::blocks(static_cast<int>(std::min<double>(most, reach + 1)));
    std::fill_n(sum, count, Orders{});
    for (const Source& source : sources) {
      const CoreSeries series = core_series(beta, source.distance, source.weight * scale);
      add_series(series, count, sum);
      // Only at the centres of the map's own texels.
      if (count == blocks() && rows_ == map_.rows()) add_folded(series, folding_, sum);
    }
    return count;
  };
  const int most = *std::max_element(used, used + levels());
  for (std::size_t k = 0; k < smooth_.size(); ++k) {
    scratch.smooth_blocks[k] =
        sum_series(smooth_[k].kernel.beta(), 1, most, scratch.smooth.data() + k * blocks());
  }
  for (int l = 0; l < levels(); ++l) {
    Orders* sum = out + l * blocks();
    const int used_blocks = Orders::blocks(used[l]);
    const int count = sum_series(kernels_[l].beta(), kernels_[l].scale(), used[l], sum);
    std::fill_n(sum + count, used_blocks - count, Orders{});
    for (std::size_t k = 0; k < smooth_.size(); ++k) {
      const Orders* smooth = scratch.smooth.data() + k * blocks();
      const auto factor = static_cast<float>(-kernels_[l].scale() * extrapolations_[l].lagrange[k]);
      const int common = std::min(used_blocks, scratch.smooth_blocks[k]);
      in_widest_registers([=]() __attribute__((always_inline)) {
        for (int b = 0; b < common; ++b) sum[b].v += factor * smooth[b].v;
      });
    }
  }
}

// Rows close to theta, and those at the poles, are integrated by Gauss's nodes; the others by the central difference of
// their neighbours' samples, f + d2 f / 24.
void CoreSum::fill_series(double theta, int first, int last, Scratch& scratch) const {
  const double at = theta / cell_ - 0.5;  // in rows of the map
  const auto near = [&](int j) {
    return std::abs(at - j) < kNearRows + 0.5 || j == 0 || j == map_.rows() - 1;
  };
  const std::size_t size = row_size();
  const int count = (last - first + kRowsAtOnce) / kRowsAtOnce * kRowsAtOnce;
  scratch.smooth.resize(smooth_.size() * blocks());
  scratch.smooth_blocks.resize(smooth_.size());
  scratch.sampled.resize(count * size);
  scratch.integrated.resize(count * size);
  scratch.used.assign(std::size_t(count) * levels(), 0);
  for (int j = first; j <= last; ++j) {
    // One row nearer, where more orders matter: the difference needs them on both sides.
    const double nearer = j < at - 1 ? j + 1 : j > at + 1 ? j - 1 : at;
    const double centre = (j + 0.5) * cell_;
    int* used = scratch.used.data() + std::size_t(j - first) * levels();
    for (int l = 0; l < levels(); ++l)
      used[l] = std::min(orders_[l], used_orders(kernels_[l].beta(), theta, (nearer + 0.5) * cell_));
    if (std::abs(at - j) > kNearRows - 0.6) {
      const Source row = source_at(theta, centre, cell_);
      sum_sources({&row, 1}, used, scratch.sampled.data() + (j - first) * size, scratch);
    }
    if (near(j)) {
      std::vector<Source> nodes;
      for (const QuadratureNode& node : cell_nodes_)
        nodes.push_back(source_at(theta, centre + node.x, node.weight));
      sum_sources(nodes, used, scratch.integrated.data() + (j - first) * size, scratch);
    }
  }
  for (int j = first; j <= last; ++j)
    if (!near(j)) integrate_between(j, first, last, scratch);
}

void CoreSum::integrate_between(int j, int first, int last, Scratch& scratch) const {
  // Where a neighbour's series ends, or the reach, there is nothing left that is worth a difference.
  const int before = j > first ? j - 1 : j, after = j < last ? j + 1 : j;
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(row_size());
  for (int l = 0; l < levels(); ++l) {
    const auto used_blocks = [&](int row) {
      return Orders::blocks(scratch.used[std::size_t(row - first) * levels() + l]);
    };
    const int own = used_blocks(j), common = std::min({own, used_blocks(before), used_blocks(after)});
    const Orders* in = scratch.sampled.data() + (j - first) * size + l * blocks();
    const Orders *in_before = in + (before - j) * size, *in_after = in + (after - j) * size;
    Orders* out = scratch.integrated.data() + (j - first) * size + l * blocks();
    in_widest_registers([=]() __attribute__((always_inline)) {
      for (int b = 0; b < common; ++b)
        out[b].v = (22.0f / 24) * in[b].v + (1.0f / 24) * (in_before[b].v + in_after[b].v);
      for (int b = common; b < own; ++b) out[b] = in[b];
    });
  }
}

// Rows that are summed together have as many orders as the one with the most.
void CoreSum::even_out(Scratch& scratch) const {
  const int rows = static_cast<int>(scratch.used.size()) / levels();
  for (int first = 0; first < rows; first += kRowsAtOnce) {
    for (int l = 0; l < levels(); ++l) {
      int* used = scratch.used.data() + std::size_t(first) * levels() + l;
      int most = 0;
      for (int r = 0; r < kRowsAtOnce; ++r) most = std::max(most, used[r * levels()]);
      for (int r = 0; r < kRowsAtOnce; ++r) {
        const int own = Orders::blocks(used[r * levels()]);
        std::fill_n(scratch.integrated.data() + (first + r) * row_size() + l * blocks() + own,
                    Orders::blocks(most) - own, Orders{});
        used[r * levels()] = most;
      }
    }
  }
}

void CoreSum::convolve(int i, StoredLanes* const* north, StoredLanes* const* south, Scratch& scratch) const {
  const int map_rows = map_.rows();
  const double theta = kPi * (i + 0.5) / rows_;
  const int nearest = std::min(static_cast<int>(theta / cell_), map_rows - 1);
  const int first = std::max(0, nearest - reach_), last = std::min(map_rows - 1, nearest + reach_);
  fill_series(theta, first, last, scratch);
  even_out(scratch);
  for (int begin = 0; begin < orders_.front(); begin += kTile) {
    for (int l = 0; l < levels(); ++l) {
      const int end = std::min(begin + kTile, orders_[l]);
      if (begin >= end) continue;
      set_smooth_part(i, l, begin, end, north[l] + begin);
      set_smooth_part(rows_ - 1 - i, l, begin, end, south[l] + begin);
    }
    for (int j = first; j <= last; j += kRowsAtOnce) {
      const StoredLanes *north_map[kRowsAtOnce], *south_map[kRowsAtOnce];
      for (int r = 0; r < kRowsAtOnce; ++r) {
        const int row = std::min(j + r, map_rows - 1);  // those beyond the last weigh nothing
        north_map[r] = map_.row(row);
        south_map[r] = map_.row(map_rows - 1 - row);
      }
      for (int l = 0; l < levels(); ++l) {
        const int until = std::min(begin + kTile, scratch.used[std::size_t(j - first) * levels() + l]);
        const float* core[kRowsAtOnce];
        for (int r = 0; r < kRowsAtOnce; ++r)
          core[r] = reinterpret_cast<const float*>(scratch.integrated.data() + (j + r - first) * row_size() +
                                                   l * blocks());
        StoredLanes *north_sum = north[l], *south_sum = south[l];
        in_widest_registers([=]() __attribute__((always_inline)) {
          for (int m = begin; m < until; ++m) {
            StoredLanes::Vector n = north_sum[m].v, s = south_sum[m].v;
            for (int r = 0; r < kRowsAtOnce; ++r) {
              n += core[r][m] * north_map[r][m].v;
              s += core[r][m] * south_map[r][m].v;
            }
            north_sum[m].v = n;
            south_sum[m].v = s;
          }
        });
      }
    }
  }
}

}  // namespace

std::vector<Image> convolve_sharp(const RowSpectrum& map, const std::vector<GgxKernel>& kernels,
                                  const std::vector<SmoothLevel>& smooth, BakeWork& work) {
  const CoreSum core(map, kernels, smooth);
  const int rows = core.rows(), width = 2 * rows;
  const int count = static_cast<int>(kernels.size());
  std::vector<Image> images;
  for (int l = 0; l < count; ++l)
    images.push_back(make_image({width, rows}, 3, SampleType::kFloat32, ColorSpace::kLinear));
  const RowFft fft(width);

  struct GroupScratch {
    std::vector<RowSpectrum> sums;  // of each level: the group's rows of the north, then of the south
    CoreSum::Scratch core;
    RowFft::Scratch fft;
  };
  ScratchPool<GroupScratch> scratches;
  using Pairs = RowPairs<StoredLanes>;
  work.parallel_for(Pairs::groups(rows), kGroupCost_us, [&](std::size_t group) {
    const int first = static_cast<int>(group) * Pairs::kCount,
              last = std::min(first + Pairs::kCount, (rows + 1) / 2);
    ScratchPool<GroupScratch>::Lease scratch(scratches);
    std::vector<RowSpectrum>& sums = scratch->sums;
    while (static_cast<int>(sums.size()) < count)
      sums.emplace_back(2 * Pairs::kCount, core.orders(static_cast<int>(sums.size())));
    std::vector<StoredLanes*> north(count), south(count);
    for (int i = first; i < last; ++i) {
      for (int l = 0; l < count; ++l) {
        north[l] = sums[l].row(i - first);
        south[l] = sums[l].row(2 * Pairs::kCount - 1 - (i - first));
      }
      core.convolve(i, north.data(), south.data(), scratch->core);
    }
    for (int l = 0; l < count; ++l) {
      float* texels = images[l].samples<float>().data();
      const auto spectrum_row = [&](int j) {
        return std::as_const(sums[l]).row(
            j < rows / 2 + rows % 2 ? j - first : 2 * Pairs::kCount - 1 - (rows - 1 - j - first));
      };
      fft.texels_of_spectra({first, rows, spectrum_row}, core.orders(l),
                            {first, rows, [&](int j) { return texels + std::size_t(j) * width * 3; }},
                            scratch->fft);
    }
  });
  return images;
}

}  // namespace furnace
