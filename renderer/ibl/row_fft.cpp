#include "renderer/ibl/row_fft.hpp"

#include <cmath>
#include <numbers>

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;

// A colour's real and imaginary parts of eight rows: rows in lanes.
struct Planes {
  Lanes re[3], im[3];

  [[gnu::always_inline]] void load(const StoredLanes* const* rows, int m) {
    Lanes block[8];
    for (int r = 0; r < 8; ++r) block[r] = rows[r][m].widen();
    transpose(block);
    for (int c = 0; c < 3; ++c) re[c] = block[2 * c], im[c] = block[2 * c + 1];
  }
  [[gnu::always_inline]] void store(StoredLanes* const* rows, int m) const {
    Lanes block[8] = {re[0], im[0], re[1], im[1], re[2], im[2], Lanes{}, Lanes{}};
    transpose(block);
    for (int r = 0; r < 8; ++r) rows[r][m] = StoredLanes::of(block[r]);
  }
  [[gnu::always_inline]] void turn(double cos, double sin) {
    for (int c = 0; c < 3; ++c) {
      const Lanes turned = cos * re[c] - sin * im[c];
      im[c] = cos * im[c] + sin * re[c];
      re[c] = turned;
    }
  }
};

// Rows of the north are real parts, those of the south imaginary ones.
struct Colours {
  ComplexLanes* planes[3];
};
using Part = Lanes ComplexLanes::*;

// Eight texels of eight rows: samples in lanes <-> rows in lanes.
[[gnu::always_inline]] inline void gather_eight(const float* const* rows, int i, const Colours& out,
                                                Part half) {
  for (int part = 0; part < 3; ++part) {
    Lanes block[8];
    for (int r = 0; r < 8; ++r) {
      StoredLanes samples;
      __builtin_memcpy(&samples, rows[r] + 3 * i + 8 * part, sizeof(samples));
      block[r] = samples.widen();
    }
    transpose(block);
    for (int k = 0; k < 8; ++k) out.planes[(8 * part + k) % 3][i + (8 * part + k) / 3].*half = block[k];
  }
}

// Not below 0, as floats.
[[gnu::always_inline]] inline void scatter_eight(const Colours& in, Part half, int i, float* const* rows) {
  for (int part = 0; part < 3; ++part) {
    Lanes block[8];
    for (int k = 0; k < 8; ++k) block[k] = in.planes[(8 * part + k) % 3][i + (8 * part + k) / 3].*half;
    transpose(block);
    for (int r = 0; r < 8; ++r) {
      const StoredLanes samples = StoredLanes::of({block[r].v > 0 ? block[r].v : Lanes::Vector{}});
      __builtin_memcpy(rows[r] + 3 * i + 8 * part, &samples, sizeof(samples));
    }
  }
}

[[gnu::always_inline]] inline void gather_texels(const RowPairs<const float>& texels, int width,
                                                 const Colours& out) {
  int i = 0;
  for (; i + 8 <= width; i += 8) {
    gather_eight(texels.north, i, out, &ComplexLanes::re);
    gather_eight(texels.south, i, out, &ComplexLanes::im);
  }
  for (; i < width; ++i) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 8; ++r) out.planes[c][i].re.set(r, texels.north[r][3 * i + c]);
      for (int r = 0; r < 8; ++r) out.planes[c][i].im.set(r, texels.south[r][3 * i + c]);
    }
  }
}

// Of a transform with exchanged parts.
[[gnu::always_inline]] inline void scatter_texels(const Colours& in, int width,
                                                  const RowPairs<float>& texels) {
  int i = 0;
  for (; i + 8 <= width; i += 8) {
    scatter_eight(in, &ComplexLanes::im, i, texels.north);
    scatter_eight(in, &ComplexLanes::re, i, texels.south);
  }
  const auto clamped = [](double value) { return static_cast<float>(value > 0 ? value : 0); };
  for (; i < width; ++i) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 8; ++r) texels.north[r][3 * i + c] = clamped(in.planes[c][i].im[r]);
      for (int r = 0; r < 8; ++r) texels.south[r][3 * i + c] = clamped(in.planes[c][i].re[r]);
    }
  }
}

// z = n + i s, w = conj(z of -m): n = (z + w) / 2, s = (z - w) / 2i
[[gnu::always_inline]] inline void split_pairs(const Colours& in, int width, int orders, const double* cos,
                                               const double* sin, const RowPairs<StoredLanes>& spectra) {
  for (int m = 0; m < orders; ++m) {
    const int mirror = m == 0 ? 0 : width - m;
    Planes north, south;
    for (int c = 0; c < 3; ++c) {
      const ComplexLanes z = in.planes[c][m], w = in.planes[c][mirror];
      north.re[c] = 0.5 * (z.re + w.re);
      north.im[c] = 0.5 * (z.im - w.im);
      south.re[c] = 0.5 * (z.im + w.im);
      south.im[c] = 0.5 * (w.re - z.re);
    }
    north.turn(cos[m], sin[m]);
    south.turn(cos[m], sin[m]);
    north.store(spectra.north, m);
    south.store(spectra.south, m);
  }
}

// Real and imaginary parts exchanged. Orders up to half the width have a bin of their own; the others are added to theirs.
template <bool kOwnBins>
[[gnu::always_inline]] inline void join_pairs(const RowPairs<const StoredLanes>& spectra, int orders,
                                              int width, const double* cos, const double* sin,
                                              const Colours& out) {
  const auto put = [](Lanes & to, const Lanes& value) __attribute__((always_inline)) {
    to = kOwnBins ? value : to + value;
  };
  for (int m = 0; m < orders; ++m) {
    Planes north, south;
    north.load(spectra.north, m);
    south.load(spectra.south, m);
    const int phase = m % (2 * width), bin = m % width, mirror = bin == 0 ? 0 : width - bin;
    north.turn(cos[phase], sin[phase]);
    south.turn(cos[phase], sin[phase]);
    for (int c = 0; c < 3; ++c) {
      put(out.planes[c][bin].im, north.re[c] - south.im[c]);
      put(out.planes[c][bin].re, north.im[c] + south.re[c]);
      if (m == 0) continue;
      put(out.planes[c][mirror].im, north.re[c] + south.im[c]);
      put(out.planes[c][mirror].re, south.re[c] - north.im[c]);
    }
  }
}

}  // namespace

RowFft::RowFft(int width) : width_(width), fft_(width) {
  for (int m = 0; m < 2 * width; ++m) {  // the phase of a texel's centre has twice the map's period
    centre_cos_.push_back(std::cos(kPi * m / width));
    centre_sin_.push_back(std::sin(kPi * m / width));
  }
  for (int m = 0; m <= width / 2; ++m) {
    const double x = kPi * m / width;
    const double mean = (m == 0 ? 1 : std::sin(x) / x) / width;
    box_cos_.push_back(mean * centre_cos_[m]);
    box_sin_.push_back(-mean * centre_sin_[m]);
  }
}

void RowFft::spectra_of_texels(const RowPairs<const float>& texels, int orders,
                               const RowPairs<StoredLanes>& spectra, Scratch& scratch) const {
  prepare(scratch);
  const Colours colours{{scratch.planes[0].data(), scratch.planes[1].data(), scratch.planes[2].data()}};
  const int width = width_;
  in_widest_registers([=]() __attribute__((always_inline)) { gather_texels(texels, width, colours); });
  for (ComplexLanes* plane : colours.planes) fft_.transform(plane, scratch.work.data());
  const double *cos = box_cos_.data(), *sin = box_sin_.data();
  in_widest_registers([=]() __attribute__((always_inline)) {
    split_pairs(colours, width, orders, cos, sin, spectra);
  });
}

void RowFft::texels_of_spectra(const RowPairs<const StoredLanes>& spectra, int orders,
                               const RowPairs<float>& texels, Scratch& scratch) const {
  prepare(scratch);
  const Colours colours{{scratch.planes[0].data(), scratch.planes[1].data(), scratch.planes[2].data()}};
  const int width = width_;
  const bool own_bins = 2 * (orders - 1) < width;
  const int first_free = own_bins ? orders : 0, free = own_bins ? width - 2 * orders + 1 : width;
  for (ComplexLanes* plane : colours.planes) std::fill_n(plane + first_free, free, ComplexLanes{});
  const double *cos = centre_cos_.data(), *sin = centre_sin_.data();
  in_widest_registers([=]() __attribute__((always_inline)) {
    if (own_bins)
      join_pairs<true>(spectra, orders, width, cos, sin, colours);
    else
      join_pairs<false>(spectra, orders, width, cos, sin, colours);
  });
  // The inverse transform is the forward one with real and imaginary parts exchanged.
  for (ComplexLanes* plane : colours.planes) fft_.transform(plane, scratch.work.data());
  in_widest_registers([=]() __attribute__((always_inline)) { scatter_texels(colours, width, texels); });
}

void RowFft::prepare(Scratch& scratch) const {
  for (std::vector<ComplexLanes>& plane : scratch.planes) plane.resize(width_);
  scratch.work.resize(width_);
}

}  // namespace furnace
