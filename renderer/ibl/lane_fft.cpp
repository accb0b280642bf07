#include "renderer/ibl/lane_fft.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace furnace {

namespace {

[[gnu::always_inline]] inline ComplexLanes operator+(const ComplexLanes& a, const ComplexLanes& b) {
  return {a.re + b.re, a.im + b.im};
}
[[gnu::always_inline]] inline ComplexLanes operator-(const ComplexLanes& a, const ComplexLanes& b) {
  return {a.re - b.re, a.im - b.im};
}
[[gnu::always_inline]] inline ComplexLanes times_minus_i(const ComplexLanes& a) {
  return {a.im, Lanes{} - a.re};
}
// a e^(-i angle)
[[gnu::always_inline]] inline ComplexLanes turn(const ComplexLanes& a, double cos, double sin) {
  return {cos * a.re + sin * a.im, cos * a.im - sin * a.re};
}

struct Pass {
  int groups, stride;
  const double *cos, *sin;
  const ComplexLanes* in;
  ComplexLanes* out;

  [[gnu::always_inline]] ComplexLanes load(int group, int k, int q) const {
    return in[q + std::size_t(stride) * (group + std::size_t(groups) * k)];
  }
  [[gnu::always_inline]] void store(int radix, int group, int j, int q, const ComplexLanes& value) const {
    const std::size_t w = std::size_t(group) * (radix - 1) + j - 1;
    out[q + std::size_t(stride) * (std::size_t(radix) * group + j)] =
        j == 0 ? value : turn(value, cos[w], sin[w]);
  }
};

[[gnu::always_inline]] inline void pass_2(const Pass pass) {
  for (int p = 0; p < pass.groups; ++p) {
    for (int q = 0; q < pass.stride; ++q) {
      const ComplexLanes a = pass.load(p, 0, q), b = pass.load(p, 1, q);
      pass.store(2, p, 0, q, a + b);
      pass.store(2, p, 1, q, a - b);
    }
  }
}

[[gnu::always_inline]] inline void pass_4(const Pass pass) {
  for (int p = 0; p < pass.groups; ++p) {
    for (int q = 0; q < pass.stride; ++q) {
      const ComplexLanes a = pass.load(p, 0, q), b = pass.load(p, 1, q);
      const ComplexLanes c = pass.load(p, 2, q), d = pass.load(p, 3, q);
      const ComplexLanes even = a + c, odd = times_minus_i(b - d);
      pass.store(4, p, 0, q, even + (b + d));
      pass.store(4, p, 1, q, (a - c) + odd);
      pass.store(4, p, 2, q, even - (b + d));
      pass.store(4, p, 3, q, (a - c) - odd);
    }
  }
}

[[gnu::always_inline]] inline void pass_8(const Pass pass) {
  constexpr double kHalf = std::numbers::sqrt2 / 2;
  for (int p = 0; p < pass.groups; ++p) {
    for (int q = 0; q < pass.stride; ++q) {
      ComplexLanes even[4], odd[4];  // of the two transforms of length four
      for (int side = 0; side < 2; ++side) {
        ComplexLanes* out = side == 0 ? even : odd;
        const ComplexLanes a = pass.load(p, side, q), b = pass.load(p, side + 2, q);
        const ComplexLanes c = pass.load(p, side + 4, q), d = pass.load(p, side + 6, q);
        const ComplexLanes turned = times_minus_i(b - d);
        out[0] = (a + c) + (b + d);
        out[1] = (a - c) + turned;
        out[2] = (a + c) - (b + d);
        out[3] = (a - c) - turned;
      }
      odd[1] = {kHalf * (odd[1].re + odd[1].im), kHalf * (odd[1].im - odd[1].re)};
      odd[2] = times_minus_i(odd[2]);
      odd[3] = {kHalf * (odd[3].im - odd[3].re), kHalf * (Lanes{} - odd[3].re - odd[3].im)};
      for (int j = 0; j < 4; ++j) {
        pass.store(8, p, j, q, even[j] + odd[j]);
        pass.store(8, p, j + 4, q, even[j] - odd[j]);
      }
    }
  }
}

[[gnu::always_inline]] inline void pass_any(const Pass pass, int radix, const double* root_cos,
                                            const double* root_sin) {
  for (int p = 0; p < pass.groups; ++p) {
    for (int q = 0; q < pass.stride; ++q) {
      for (int j = 0; j < radix; ++j) {
        ComplexLanes sum = pass.load(p, 0, q);
        for (int k = 1; k < radix; ++k) {
          const int turns = static_cast<int>(std::int64_t{j} * k % radix);
          sum = sum + turn(pass.load(p, k, q), root_cos[turns], root_sin[turns]);
        }
        pass.store(radix, p, j, q, sum);
      }
    }
  }
}

int next_radix(int n) {
  if (n % 8 == 0 && n != 16) return 8;
  if (n % 4 == 0) return 4;
  for (int p = 2; p * p <= n; ++p)
    if (n % p == 0) return p;
  return n;
}

}  // namespace

// Stockham's self-sorting form (Van Loan 1992, "Computational Frameworks for the Fast Fourier Transform", 1.7).
LaneFft::LaneFft(int n) : n_(n) {
  for (int length = n, stride = 1; length > 1;) {
    Stage stage;
    stage.radix = next_radix(length);
    stage.groups = length / stage.radix;
    stage.stride = stride;
    for (int p = 0; p < stage.groups; ++p) {
      for (int j = 1; j < stage.radix; ++j) {
        const double angle = 2 * std::numbers::pi * double(p) * j / length;
        stage.cos.push_back(std::cos(angle));
        stage.sin.push_back(std::sin(angle));
      }
    }
    for (int j = 0; j < stage.radix; ++j) {
      stage.root_cos.push_back(std::cos(2 * std::numbers::pi * j / stage.radix));
      stage.root_sin.push_back(std::sin(2 * std::numbers::pi * j / stage.radix));
    }
    stride *= stage.radix;
    length = stage.groups;
    stages_.push_back(std::move(stage));
  }
}

void LaneFft::transform(ComplexLanes* values, ComplexLanes* work) const {
  ComplexLanes *in = values, *out = work;
  for (const Stage& stage : stages_) {
    const Pass pass{stage.groups, stage.stride, stage.cos.data(), stage.sin.data(), in, out};
    const int radix = stage.radix;
    const double *root_cos = stage.root_cos.data(), *root_sin = stage.root_sin.data();
    in_widest_registers([=]() __attribute__((always_inline)) {
      if (radix == 8) return pass_8(pass);
      if (radix == 4) return pass_4(pass);
      if (radix == 2) return pass_2(pass);
      pass_any(pass, radix, root_cos, root_sin);
    });
    std::swap(in, out);
  }
  if (in != values) std::copy_n(in, n_, values);
}

}  // namespace furnace
