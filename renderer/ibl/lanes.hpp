// Eight doubles that are computed together, in the widest registers the processor has.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

namespace furnace {

// One cache line: eight rows of a map, or the colour of one Fourier coefficient (R.re R.im G.re G.im B.re B.im and two
// spare zeros). Every operation treats the eight alike, so the width of the registers changes no bit. Where a product is
// fused with a sum (the sources that CMakeLists.txt names), it is by every processor that can: those without AVX2 and FMA
// differ in the last bits.
struct alignas(64) Lanes {
  typedef double Vector __attribute__((vector_size(64)));

  Vector v;  // Lanes{} is zero, plain Lanes is not set

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

// Lanes at rest: what 8 floats keep of them, in half the memory.
struct alignas(32) StoredLanes {
  typedef float Vector __attribute__((vector_size(32)));

  Vector v;

  [[gnu::always_inline]] static StoredLanes of(const Lanes& lanes) {
    return {__builtin_convertvector(lanes.v, Vector)};
  }
  [[gnu::always_inline]] Lanes widen() const { return {__builtin_convertvector(v, Lanes::Vector)}; }
};

namespace detail {

// Lanes of `a` whose number has the bit `kDistance` <-> those of `b` without it.
template <int kDistance, int... kLane>
[[gnu::always_inline]] inline void exchange(Lanes& a, Lanes& b, std::integer_sequence<int, kLane...>) {
  const Lanes::Vector x = a.v, y = b.v;
  a.v = __builtin_shufflevector(x, y, (kLane & kDistance ? 8 + kLane - kDistance : kLane)...);
  b.v = __builtin_shufflevector(x, y, (kLane & kDistance ? 8 + kLane : kLane + kDistance)...);
}

template <int kDistance>
[[gnu::always_inline]] inline void exchange_pairs(Lanes (&block)[8]) {
  for (int k = 0; k < 8; ++k)
    if (!(k & kDistance))
      exchange<kDistance>(block[k], block[k + kDistance], std::make_integer_sequence<int, 8>());
}

}  // namespace detail

// Lane i of block[k] <-> lane k of block[i].
[[gnu::always_inline]] inline void transpose(Lanes (&block)[8]) {
  detail::exchange_pairs<1>(block);
  detail::exchange_pairs<2>(block);
  detail::exchange_pairs<4>(block);
}

#if defined(__x86_64__)

namespace detail {

template <class Body>
[[gnu::target("avx512f,fma")]] void run_with_avx512(const Body& body) {
  body();
}
template <class Body>
[[gnu::target("avx2,fma")]] void run_with_avx2(const Body& body) {
  body();
}

}  // namespace detail

// How many doubles a register of in_widest_registers holds: 2, 4 or 8.
inline int register_doubles() {
  if (__builtin_cpu_supports("avx512f")) return 8;
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? 4 : 2;
}

// Runs `body`, compiled for each instruction set. Example:
//   in_widest_registers([=]() __attribute__((always_inline)) { ... });   without the attribute it stays narrow
template <class Body>
void in_widest_registers(const Body& body) {
  const int doubles = register_doubles();
  if (doubles == 8) return detail::run_with_avx512(body);
  if (doubles == 4) return detail::run_with_avx2(body);
  body();
}

#else

inline int register_doubles() {
  return 2;
}

template <class Body>
void in_widest_registers(const Body& body) {
  body();
}

#endif

inline void store(const Lanes* lanes, int count, StoredLanes* out) {
  in_widest_registers([=]() __attribute__((always_inline)) {
    for (int k = 0; k < count; ++k) out[k] = StoredLanes::of(lanes[k]);
  });
}

// The largest of many samples, 0 if none is positive.
inline float largest_sample(std::span<const float> samples) {
  StoredLanes largest = {};
  const float* in = samples.data();
  const std::size_t whole = samples.size() / 8 * 8;
  in_widest_registers([&]() __attribute__((always_inline)) {
    StoredLanes::Vector most = {};
    for (std::size_t i = 0; i < whole; i += 8) {
      StoredLanes::Vector eight;
      __builtin_memcpy(&eight, in + i, sizeof(eight));
      most = most > eight ? most : eight;
    }
    largest.v = most;
  });
  float result = 0;
  for (int k = 0; k < 8; ++k) result = std::max(result, largest.v[k]);
  for (const float sample : samples.subspan(whole)) result = std::max(result, sample);
  return result;
}

}  // namespace furnace
