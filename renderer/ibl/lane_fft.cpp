#include "renderer/ibl/lane_fft.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace furnace {

namespace {

// Some lanes of a complex number, as many as a register has.
template <class Vector>
struct Complex {
  Vector re, im;

  [[gnu::always_inline]] friend Complex operator+(const Complex& a, const Complex& b) {
    return {a.re + b.re, a.im + b.im};
  }
  [[gnu::always_inline]] friend Complex operator-(const Complex& a, const Complex& b) {
    return {a.re - b.re, a.im - b.im};
  }
};

template <class Vector>
[[gnu::always_inline]] inline Complex<Vector> times_minus_i(const Complex<Vector>& a) {
  return {a.im, -a.re};
}
// a e^(-i angle)
template <class Vector>
[[gnu::always_inline]] inline Complex<Vector> turn(const Complex<Vector>& a, double cos, double sin) {
  return {cos * a.re + sin * a.im, cos * a.im - sin * a.re};
}

template <class Vector>
struct Pass {
  using Value = Complex<Vector>;

  int groups, stride;
  const double *cos, *sin;
  const ComplexLanes* in;
  ComplexLanes* out;
  int lane = 0;  // the first of those that are worked on

  [[gnu::always_inline]] Value load(int group, int k, int q) const {
    const ComplexLanes& from = in[q + std::size_t(stride) * (group + std::size_t(groups) * k)];
    Value value;
    __builtin_memcpy(&value.re, reinterpret_cast<const double*>(&from.re) + lane, sizeof(Vector));
    __builtin_memcpy(&value.im, reinterpret_cast<const double*>(&from.im) + lane, sizeof(Vector));
    return value;
  }
  [[gnu::always_inline]] void store(int radix, int group, int j, int q, const Value& value) const {
    const std::size_t w = std::size_t(group) * (radix - 1) + j - 1;
    const Value turned = j == 0 ? value : turn(value, cos[w], sin[w]);
    ComplexLanes& to = out[q + std::size_t(stride) * (std::size_t(radix) * group + j)];
    __builtin_memcpy(reinterpret_cast<double*>(&to.re) + lane, &turned.re, sizeof(Vector));
    __builtin_memcpy(reinterpret_cast<double*>(&to.im) + lane, &turned.im, sizeof(Vector));
  }

  [[gnu::always_inline]] void butterfly_2(int p, int q) const {
    const Value a = load(p, 0, q), b = load(p, 1, q);
    store(2, p, 0, q, a + b);
    store(2, p, 1, q, a - b);
  }

  [[gnu::always_inline]] void butterfly_4(int p, int q) const {
    const Value a = load(p, 0, q), b = load(p, 1, q);
    const Value c = load(p, 2, q), d = load(p, 3, q);
    const Value even = a + c, odd = times_minus_i(b - d);
    store(4, p, 0, q, even + (b + d));
    store(4, p, 1, q, (a - c) + odd);
    store(4, p, 2, q, even - (b + d));
    store(4, p, 3, q, (a - c) - odd);
  }

  [[gnu::always_inline]] void butterfly_8(int p, int q) const {
    constexpr double kHalf = std::numbers::sqrt2 / 2;
    Value even[4], odd[4];  // of the two transforms of length four
    for (int side = 0; side < 2; ++side) {
      Value* half = side == 0 ? even : odd;
      const Value a = load(p, side, q), b = load(p, side + 2, q);
      const Value c = load(p, side + 4, q), d = load(p, side + 6, q);
      const Value turned = times_minus_i(b - d);
      half[0] = (a + c) + (b + d);
      half[1] = (a - c) + turned;
      half[2] = (a + c) - (b + d);
      half[3] = (a - c) - turned;
    }
    odd[1] = {kHalf * (odd[1].re + odd[1].im), kHalf * (odd[1].im - odd[1].re)};
    odd[2] = times_minus_i(odd[2]);
    odd[3] = {kHalf * (odd[3].im - odd[3].re), kHalf * (-odd[3].re - odd[3].im)};
    for (int j = 0; j < 4; ++j) {
      store(8, p, j, q, even[j] + odd[j]);
      store(8, p, j + 4, q, even[j] - odd[j]);
    }
  }

  [[gnu::always_inline]] void butterfly_any(int p, int q, int radix, const double* root_cos,
                                            const double* root_sin) const {
    for (int j = 0; j < radix; ++j) {
      Value sum = load(p, 0, q);
      for (int k = 1; k < radix; ++k) {
        const int turns = static_cast<int>(std::int64_t{j} * k % radix);
        sum = sum + turn(load(p, k, q), root_cos[turns], root_sin[turns]);
      }
      store(radix, p, j, q, sum);
    }
  }

  [[gnu::always_inline]] void run(int radix, const double* root_cos, const double* root_sin) {
    for (int p = 0; p < groups; ++p) {
      for (int q = 0; q < stride; ++q) {
        for (lane = 0; lane < 8; lane += int(sizeof(Vector) / sizeof(double))) {
          if (radix == 8)
            butterfly_8(p, q);
          else if (radix == 4)
            butterfly_4(p, q);
          else if (radix == 2)
            butterfly_2(p, q);
          else
            butterfly_any(p, q, radix, root_cos, root_sin);
        }
      }
    }
  }
};

typedef double Two __attribute__((vector_size(16)));
typedef double Four __attribute__((vector_size(32)));
typedef Lanes::Vector Eight;

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
  const int width = register_doubles();
  for (const Stage& stage : stages_) {
    const int radix = stage.radix, groups = stage.groups, stride = stage.stride;
    const double *cos = stage.cos.data(), *sin = stage.sin.data();
    const double *root_cos = stage.root_cos.data(), *root_sin = stage.root_sin.data();
    in_widest_registers([=]() __attribute__((always_inline)) {
      if (width == 8)
        Pass<Eight>{groups, stride, cos, sin, in, out}.run(radix, root_cos, root_sin);
      else if (width == 4)
        Pass<Four>{groups, stride, cos, sin, in, out}.run(radix, root_cos, root_sin);
      else
        Pass<Two>{groups, stride, cos, sin, in, out}.run(radix, root_cos, root_sin);
    });
    std::swap(in, out);
  }
  if (in != values) std::copy_n(in, n_, values);
}

}  // namespace furnace
