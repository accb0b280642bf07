// Eight doubles that are computed together, in the widest registers the processor has.
#pragma once

namespace furnace {

// One cache line: eight rows of a map, or the colour of one Fourier coefficient (R.re R.im G.re G.im B.re B.im and two
// spare zeros). Every operation treats the eight alike and products are never fused, so the width of the registers
// changes no bit.
struct alignas(64) Lanes {
  typedef double Vector __attribute__((vector_size(64)));

  Vector v = {};

  double operator[](int i) const { return v[i]; }
  void set(int i, double value) { v[i] = value; }

  [[gnu::always_inline]] static Lanes all(double value) { return {value - Vector{}}; }
  [[gnu::always_inline]] Lanes& operator+=(const Lanes& other) {
    v += other.v;
    return *this;
  }
  [[gnu::always_inline]] friend Lanes operator+(const Lanes& a, const Lanes& b) { return {a.v + b.v}; }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a, const Lanes& b) { return {a.v - b.v}; }
  [[gnu::always_inline]] friend Lanes operator*(const Lanes& a, const Lanes& b) { return {a.v * b.v}; }
  [[gnu::always_inline]] friend Lanes operator*(double a, const Lanes& b) { return {a * b.v}; }
};

#if defined(__x86_64__)

namespace detail {

template <class Body>
[[gnu::target("avx512f")]] void run_with_avx512(const Body& body) {
  body();
}
template <class Body>
[[gnu::target("avx2")]] void run_with_avx2(const Body& body) {
  body();
}

}  // namespace detail

// Runs `body`, compiled for each instruction set. Example:
//   in_widest_registers([=]() __attribute__((always_inline)) { ... });   without the attribute it stays narrow
template <class Body>
void in_widest_registers(const Body& body) {
  if (__builtin_cpu_supports("avx512f")) return detail::run_with_avx512(body);
  if (__builtin_cpu_supports("avx2")) return detail::run_with_avx2(body);
  body();
}

#else

template <class Body>
void in_widest_registers(const Body& body) {
  body();
}

#endif

}  // namespace furnace
