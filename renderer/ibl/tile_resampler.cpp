#include "renderer/ibl/tile_resampler.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "renderer/base/check.hpp"
#include "renderer/ibl/lanes.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSampleCost_us = 0.03;
constexpr double kTexelCost_us = 0.005;
constexpr int kBlockRows = 8;
constexpr int kBlockColumns = 32;

// Where a 4 x 4 window lies along one axis, and the weights of its samples.
struct Tap {
  int first = 0;  // index of the first sample, -2 at least
  float weight[4] = {};
};

// The cubic through four samples, between the middle two (Keys 1981, "Cubic Convolution Interpolation for Digital Image
// Processing").
[[gnu::always_inline]] inline Tap tap_at(double position, int count) {
  const double x = std::clamp(position, -0.5, count - 0.5);
  const int cell = static_cast<int>(std::floor(x));
  const double s = x - cell;
  return {
      cell - 1,
      {static_cast<float>(s * (-0.5 + s * (1 - 0.5 * s))), static_cast<float>(1 + s * s * (-2.5 + 1.5 * s)),
       static_cast<float>(s * (0.5 + s * (2 - 1.5 * s))), static_cast<float>(s * s * (-0.5 + 0.5 * s))}};
}

[[gnu::always_inline]] inline Quad::Vector min(const Quad::Vector& a, const Quad::Vector& b) {
  return a < b ? a : b;
}
[[gnu::always_inline]] inline Quad::Vector max(const Quad::Vector& a, const Quad::Vector& b) {
  return a > b ? a : b;
}

// RGB of a texel and a sample of the next.
[[gnu::always_inline]] inline Quad::Vector quad_at(const float* samples) {
  Quad::Vector quad;
  __builtin_memcpy(&quad, samples, sizeof(quad));
  return quad;
}

// Bicubic, but not below half of the least of the four samples around: beside a sun a cubic undershoots. The fourth sample of
// the result means nothing.
[[gnu::always_inline]] inline Quad sample(const float* const* rows, const Tap& column, const Tap& row) {
  Quad::Vector cubic = {};
  for (int k = 0; k < 4; ++k) {
    Quad::Vector sum = row.weight[0] * quad_at(rows[0] + 3 * k);
    for (int b = 1; b < 4; ++b) sum += row.weight[b] * quad_at(rows[b] + 3 * k);
    cubic += column.weight[k] * sum;
  }
  const float *upper = rows[1], *lower = rows[2];
  return {max(cubic, 0.5f * min(min(quad_at(upper + 3), quad_at(upper + 6)),
                                min(quad_at(lower + 3), quad_at(lower + 6))))};
}

// A map that is continued around and over the poles.
class Continued {
 public:
  explicit Continued(const Image& equirect)
      : texels_(equirect.samples<float>().data()),
        width_(equirect.extent.width),
        height_(equirect.extent.height) {}

  int width() const { return width_; }
  int height() const { return height_; }

  [[gnu::always_inline]] void prefetch(int column, int row) const {
    const int i = std::clamp(column, 0, width_ - 1), last = height_ - 1;
    for (int k = 0; k < 4; ++k)
      __builtin_prefetch(texels_ + 3 * (std::size_t(std::clamp(row + k, 0, last)) * width_ + i));
  }

  // Four rows' texels from `column` on, four and a sample: in `copies` where the map does not have them side by side.
  [[gnu::always_inline]] void windows(int column, int row, float (&copies)[4][13],
                                      const float* (&out)[4]) const {
    if (row >= 0 && row + 4 <= height_ && column >= 0 && column + 4 < width_) {
      out[0] = texels_ + 3 * (std::size_t(row) * width_ + column);
      for (int k = 1; k < 4; ++k) out[k] = out[k - 1] + 3 * width_;
    } else {
      for (int k = 0; k < 4; ++k) out[k] = copied(column, row + k, copies[k]);
    }
  }

 private:
  [[gnu::noinline]] const float* copied(int column, int row, float* copy) const {
    const int j = row < 0 ? -1 - row : row >= height_ ? 2 * height_ - 1 - row : row;
    const int turn = j == row ? 0 : width_ / 2;
    for (int k = 0; k < 4; ++k) {
      const int i = ((column + turn + k) % width_ + width_) % width_;
      std::copy_n(texels_ + 3 * (std::size_t(j) * width_ + i), 3, copy + 3 * k);
    }
    copy[12] = 0;
    return copy;
  }

  const float* texels_;
  int width_ = 0;   // px
  int height_ = 0;  // px
};

}  // namespace

TexelIndex fold_octahedral(int i, int j, int inner) {
  if (i < 0 || i >= inner) {
    i = i < 0 ? -1 - i : 2 * inner - 1 - i;
    j = inner - 1 - j;
  }
  if (j < 0 || j >= inner) {
    j = j < 0 ? -1 - j : 2 * inner - 1 - j;
    i = inner - 1 - i;
  }
  return {i, j};
}

void TileResampler::resample(const Image& equirect, float scale, const TileTexels& tile) {
  FURNACE_CHECK(tile.inner % 2 == 0, "a tile of {} texels", tile.inner);
  const std::size_t texels = std::size_t(tile.inner) * tile.inner;
  if (capacity_ < texels) {
    sampled_ = std::make_unique_for_overwrite<Quad[]>(texels);
    capacity_ = texels;
  }
  sample_all(equirect, tile.inner);
  sharpen(scale, tile);
}

namespace {

// One of a block of texels that are sampled together: half-tile indices from the middle of the tile.
struct Place {
  int a = 0, b = 0;
  double phi = 0;  // rad
  Tap rows[2];     // north, south
  Tap column;      // of one symmetry
};

Place place_at(int a, int b, int inner, int height) {
  const double x = (2 * a + 1) / double(inner), z = (2 * b + 1) / double(inner);
  const double theta = std::atan2(std::sqrt(x * x + z * z), 1 - x - z);
  const double north = theta / kPi * height - 0.5;
  return {a, b, std::atan2(z, x), {tap_at(north, height), tap_at(height - 1 - north, height)}, {}};
}

// The octahedron's sixteen symmetries: three of a half, and north and south.
struct Symmetry {
  bool swap, minus_x, minus_z;

  double turned(double phi) const {
    const double angle = swap ? kPi / 2 - phi : phi;
    const double mirrored = minus_x ? kPi - angle : angle;
    return minus_z ? -mirrored : mirrored;
  }
};

// Each block once for each symmetry: neighbours read neighbours of the map, and write them.
[[gnu::always_inline]] inline void sample_block(const Continued& map, std::span<Place> places, int inner,
                                                Quad* out) {
  const int half = inner / 2;
  for (int s = 0; s < 8; ++s) {
    const Symmetry symmetry{(s & 1) != 0, (s & 2) != 0, (s & 4) != 0};
    for (Place& place : places) {
      const double u = symmetry.turned(place.phi) / (2 * kPi) + 0.5;
      place.column = tap_at(u * map.width() - 0.5, map.width());
      for (const Tap& row : place.rows) map.prefetch(place.column.first, row.first);
    }
    for (int south = 0; south < 2; ++south) {
      for (const Place& place : places) {
        float copies[4][13];
        const float* windows[4];
        map.windows(place.column.first, place.rows[south].first, copies, windows);
        // The southern half is folded outwards: (x, z) -> (1 - z, 1 - x).
        const int from_x = symmetry.swap ? place.b : place.a, from_z = symmetry.swap ? place.a : place.b;
        const int i = south ? half - 1 - from_z : from_x, j = south ? half - 1 - from_x : from_z;
        const int to_i = symmetry.minus_x ? half - 1 - i : half + i,
                  to_j = symmetry.minus_z ? half - 1 - j : half + j;
        out[std::size_t(to_j) * inner + to_i] = sample(windows, place.column, place.rows[south]);
      }
    }
  }
}

}  // namespace

// Symmetries map texel centres to texel centres, so the angles of one sixteenth serve for all: 0 <= z <= x, y >= 0, that is
// half-tile indices b <= a, a + b < inner / 2.
void TileResampler::sample_all(const Image& equirect, int inner) {
  const int half = inner / 2, rows = (half + 1) / 2;
  const Continued map(equirect);
  Quad* out = sampled_.get();
  const double cost_us = kSampleCost_us * 8 * half * kBlockRows;
  pool_.parallel_for((rows + kBlockRows - 1) / kBlockRows, cost_us, [&](std::size_t block) {
    const int first = static_cast<int>(block) * kBlockRows, last = std::min(first + kBlockRows, rows);
    std::vector<Place> places;
    for (int begin = first; begin + first < half; begin += kBlockColumns) {
      places.clear();
      for (int b = first; b < last; ++b)
        for (int a = std::max(begin, b); a < std::min(begin + kBlockColumns, half - b); ++a)
          places.push_back(place_at(a, b, inner, map.height()));
      in_widest_registers([&]() __attribute__((always_inline)) { sample_block(map, places, inner, out); });
    }
  });
}

// Reading f linearly between samples adds h^2 f'' / 12 in the mean; taking as much off the samples leaves the least mean
// square error of any piecewise linear function, to that order (Blu, Thevenaz and Unser 2004, "Linear Interpolation
// Revitalized"). Held above half of the sample, so that nothing turns negative beside a sun.
void TileResampler::sharpen(float scale, const TileTexels& tile) {
  const int inner = tile.inner;
  const Quad* sampled = sampled_.get();
  pool_.parallel_for(inner, kTexelCost_us * inner, [&, inner, sampled](std::size_t row) {
    const int j = static_cast<int>(row);
    typedef int Mask __attribute__((vector_size(16)));
    const Mask colour = {-1, -1, -1, 0};
    const Quad::Vector opaque = {0, 0, 0, 1};
    std::vector<Quad> texels(inner);
    const auto at = [&](int i, int j) -> const Quad::Vector& {
      const TexelIndex folded = fold_octahedral(i, j, inner);
      return sampled[std::size_t(folded.j) * inner + folded.i].v;
    };
    const auto sharpened = [&](const Quad::Vector& f, const Quad::Vector& around) {
      return Quad{colour ? scale * max(f - (around - 4.0f * f) * (1.0f / 12), 0.5f * f) : opaque};
    };
    const Quad* in = sampled + row * inner;
    const auto at_edge = [&](int i) {
      return sharpened(in[i].v, at(i - 1, j) + at(i + 1, j) + at(i, j - 1) + at(i, j + 1));
    };
    const bool edge_row = j == 0 || j == inner - 1;
    for (int i = 1; i < inner - 1; ++i) {
      texels[i] = edge_row
                      ? at_edge(i)
                      : sharpened(in[i].v, in[i - 1].v + in[i + 1].v + in[i - inner].v + in[i + inner].v);
    }
    texels[0] = at_edge(0);
    texels[inner - 1] = at_edge(inner - 1);
    const std::size_t first = (std::size_t(tile.y + j) * tile.image.extent.width + tile.x) * 4;
    half_from_float({reinterpret_cast<const float*>(texels.data()), std::size_t(inner) * 4},
                    tile.image.samples<std::uint16_t>().subspan(first, std::size_t(inner) * 4));
  });
}

}  // namespace furnace
