#include "renderer/ibl/tile_resampler.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/base/check.hpp"
#include "renderer/ibl/lanes.hpp"

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kMargin = 2;  // px of the padded equirect on each side
constexpr double kSampleCost_us = 0.03;
constexpr double kTexelCost_us = 0.005;

// Where a 4 x 4 window lies along one axis, and the weights of its samples.
struct Tap {
  int first = 0;  // index of the first sample in the padded map
  float weight[4] = {};
};

// The cubic through four samples, between the middle two (Keys 1981, "Cubic Convolution Interpolation for Digital Image
// Processing").
[[gnu::always_inline]] inline Tap tap_at(double position, int count) {
  const double x = std::clamp(position, -0.5, count - 0.5);
  const int cell = static_cast<int>(std::floor(x));
  const double s = x - cell;
  return {
      cell - 1 + kMargin,
      {static_cast<float>(s * (-0.5 + s * (1 - 0.5 * s))), static_cast<float>(1 + s * s * (-2.5 + 1.5 * s)),
       static_cast<float>(s * (0.5 + s * (2 - 1.5 * s))), static_cast<float>(s * s * (-0.5 + 0.5 * s))}};
}

[[gnu::always_inline]] inline Quad::Vector min(const Quad::Vector& a, const Quad::Vector& b) {
  return a < b ? a : b;
}
[[gnu::always_inline]] inline Quad::Vector max(const Quad::Vector& a, const Quad::Vector& b) {
  return a > b ? a : b;
}

// Four texels of a row.
struct Window {
  typedef float Vector __attribute__((vector_size(64)));
  Vector v;
};

[[gnu::always_inline]] inline Window weights_of(const Tap& column) {
  Window weights;
  for (int k = 0; k < 16; ++k) weights.v[k] = column.weight[k / 4];
  return weights;
}

// Bicubic, but not below half of the least of the four samples around: beside a sun a cubic undershoots.
[[gnu::always_inline]] inline Quad sample(const Quad* padded, int stride, int first_column,
                                          const Window& columns, const Tap& row) {
  const Quad* corner = padded + std::size_t(row.first) * stride + first_column;
  Window::Vector sum = {};
  for (int b = 0; b < 4; ++b) {
    Window window;
    __builtin_memcpy(&window, corner + std::size_t(b) * stride, sizeof(window));
    sum += row.weight[b] * window.v;
  }
  sum *= columns.v;
  Quad::Vector part[4];
  __builtin_memcpy(part, &sum, sizeof(part));
  const Quad *upper = corner + stride + 1, *lower = upper + stride;
  return {max((part[0] + part[1]) + (part[2] + part[3]),
              0.5f * min(min(upper[0].v, upper[1].v), min(lower[0].v, lower[1].v)))};
}

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

const std::vector<Quad>& TileResampler::resample(const Image& equirect, int inner) {
  FURNACE_CHECK(inner % 2 == 0, "a tile of {} texels", inner);
  pad(equirect);
  sample_all(inner);
  sharpen(inner);
  return tile_;
}

// Continued around the map and over the poles, so that every window lies in memory as it stands.
void TileResampler::pad(const Image& equirect) {
  width_ = equirect.extent.width;
  height_ = equirect.extent.height;
  const int stride = width_ + 2 * kMargin, rows = height_ + 2 * kMargin;
  padded_.resize(std::size_t(stride) * rows);
  const float* texels = equirect.samples<float>().data();
  pool_.parallel_for(rows, kTexelCost_us * stride, [&](std::size_t padded_row) {
    const int y = static_cast<int>(padded_row) - kMargin;
    const int j = y < 0 ? -1 - y : y >= height_ ? 2 * height_ - 1 - y : y;
    const int turn = j == y ? 0 : width_ / 2;
    const float* in = texels + std::size_t(j) * width_ * 3;
    Quad* out = padded_.data() + padded_row * stride;
    for (int x = 0; x < stride; ++x) {
      const int column = x - kMargin + turn;
      const float* p = in + 3 * (column < 0 ? column + width_ : column >= width_ ? column - width_ : column);
      out[x].v = Quad::Vector{p[0], p[1], p[2], 0};
    }
  });
}

// The octahedron's sixteen symmetries map texel centres to texel centres, so the angles of one sixteenth serve for all:
// 0 <= z <= x, y >= 0, that is half-tile indices b <= a, a + b < inner / 2.
void TileResampler::sample_all(int inner) {
  sampled_.resize(std::size_t(inner) * inner);
  const int half = inner / 2, stride = width_ + 2 * kMargin;
  const int width = width_, height = height_;
  const Quad* padded = padded_.data();
  Quad* out = sampled_.data();
  pool_.parallel_for((half + 1) / 2, kSampleCost_us * 8 * half, [=](std::size_t index) {
    const int b = static_cast<int>(index);
    in_widest_registers([=]() __attribute__((always_inline)) {
      for (int a = b; a + b < half; ++a) {
        const double x = (2 * a + 1) / double(inner), z = (2 * b + 1) / double(inner);
        const double phi = std::atan2(z, x), theta = std::atan2(std::sqrt(x * x + z * z), 1 - x - z);
        const double north = theta / kPi * height - 0.5;
        const Tap rows[2] = {tap_at(north, height), tap_at(height - 1 - north, height)};
        for (int symmetry = 0; symmetry < 8; ++symmetry) {
          const bool swap = symmetry & 1, minus_x = symmetry & 2, minus_z = symmetry & 4;
          double angle = swap ? kPi / 2 - phi : phi;
          if (minus_x) angle = kPi - angle;
          if (minus_z) angle = -angle;
          const Tap column = tap_at((angle / (2 * kPi) + 0.5) * width - 0.5, width);
          const Window columns = weights_of(column);
          for (int south = 0; south < 2; ++south) {
            // The southern half is folded outwards: (x, z) -> (1 - z, 1 - x).
            const int from_x = swap ? b : a, from_z = swap ? a : b;
            const int i = south ? half - 1 - from_z : from_x, j = south ? half - 1 - from_x : from_z;
            const int to_i = minus_x ? half - 1 - i : half + i, to_j = minus_z ? half - 1 - j : half + j;
            out[std::size_t(to_j) * inner + to_i] =
                sample(padded, stride, column.first, columns, rows[south]);
          }
        }
      }
    });
  });
}

// Reading f linearly between samples adds h^2 f'' / 12 in the mean; taking as much off the samples leaves the least mean
// square error of any piecewise linear function, to that order (Blu, Thevenaz and Unser 2004, "Linear Interpolation
// Revitalized"). Held above half of the sample, so that nothing turns negative beside a sun.
void TileResampler::sharpen(int inner) {
  tile_.resize(sampled_.size());
  pool_.parallel_for(inner, kTexelCost_us * inner, [&](std::size_t row) {
    const int j = static_cast<int>(row);
    const auto at = [&](int i, int j) -> const Quad::Vector& {
      const TexelIndex folded = fold_octahedral(i, j, inner);
      return sampled_[std::size_t(folded.j) * inner + folded.i].v;
    };
    const auto sharpened = [&](const Quad::Vector& f, const Quad::Vector& around) {
      return Quad{max(f - (around - 4.0f * f) * (1.0f / 12), 0.5f * f)};
    };
    Quad* out = tile_.data() + row * inner;
    const Quad* in = sampled_.data() + row * inner;
    const bool edge_row = j == 0 || j == inner - 1;
    for (int i = 0; i < inner; ++i) {
      if (edge_row || i == 0 || i == inner - 1)
        out[i] = sharpened(in[i].v, at(i - 1, j) + at(i + 1, j) + at(i, j - 1) + at(i, j + 1));
      else
        out[i] = sharpened(in[i].v, in[i - 1].v + in[i + 1].v + in[i - inner].v + in[i + inner].v);
    }
  });
}

}  // namespace furnace
