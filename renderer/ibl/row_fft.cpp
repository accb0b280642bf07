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

struct Colours {
  Lanes *re[3], *im[3];
};

// Eight texels of eight rows: samples in lanes <-> rows in lanes.
[[gnu::always_inline]] inline void gather_eight(const float* const* rows, int i, Lanes* const* planes) {
  for (int part = 0; part < 3; ++part) {
    Lanes block[8];
    for (int r = 0; r < 8; ++r) {
      StoredLanes samples;
      __builtin_memcpy(&samples, rows[r] + 3 * i + 8 * part, sizeof(samples));
      block[r] = samples.widen();
    }
    transpose(block);
    for (int k = 0; k < 8; ++k) planes[(8 * part + k) % 3][i + (8 * part + k) / 3] = block[k];
  }
}

// Not below 0, as floats.
[[gnu::always_inline]] inline void scatter_eight(const Lanes* const* planes, int i, float* const* rows) {
  for (int part = 0; part < 3; ++part) {
    Lanes block[8];
    for (int k = 0; k < 8; ++k) block[k] = planes[(8 * part + k) % 3][i + (8 * part + k) / 3];
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
    gather_eight(texels.north, i, out.re);
    gather_eight(texels.south, i, out.im);
  }
  for (; i < width; ++i) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 8; ++r) out.re[c][i].set(r, texels.north[r][3 * i + c]);
      for (int r = 0; r < 8; ++r) out.im[c][i].set(r, texels.south[r][3 * i + c]);
    }
  }
}

[[gnu::always_inline]] inline void scatter_texels(const Colours& in, int width,
                                                  const RowPairs<float>& texels) {
  int i = 0;
  for (; i + 8 <= width; i += 8) {
    scatter_eight(in.re, i, texels.north);
    scatter_eight(in.im, i, texels.south);
  }
  const auto clamped = [](double value) { return static_cast<float>(value > 0 ? value : 0); };
  for (; i < width; ++i) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 8; ++r) texels.north[r][3 * i + c] = clamped(in.re[c][i][r]);
      for (int r = 0; r < 8; ++r) texels.south[r][3 * i + c] = clamped(in.im[c][i][r]);
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
      north.re[c] = 0.5 * (in.re[c][m] + in.re[c][mirror]);
      north.im[c] = 0.5 * (in.im[c][m] - in.im[c][mirror]);
      south.re[c] = 0.5 * (in.im[c][m] + in.im[c][mirror]);
      south.im[c] = 0.5 * (in.re[c][mirror] - in.re[c][m]);
    }
    north.turn(cos[m], sin[m]);
    south.turn(cos[m], sin[m]);
    north.store(spectra.north, m);
    south.store(spectra.south, m);
  }
}

// Orders up to half the width have a bin of their own; the others are added to theirs.
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
      put(out.re[c][bin], north.re[c] - south.im[c]);
      put(out.im[c][bin], north.im[c] + south.re[c]);
      if (m == 0) continue;
      put(out.re[c][mirror], north.re[c] + south.im[c]);
      put(out.im[c][mirror], south.re[c] - north.im[c]);
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
  const Colours colours{{scratch.re[0].data(), scratch.re[1].data(), scratch.re[2].data()},
                        {scratch.im[0].data(), scratch.im[1].data(), scratch.im[2].data()}};
  const int width = width_;
  in_widest_registers([=]() __attribute__((always_inline)) { gather_texels(texels, width, colours); });
  for (int c = 0; c < 3; ++c) fft_.transform(colours.re[c], colours.im[c], scratch.work.data());
  const double *cos = box_cos_.data(), *sin = box_sin_.data();
  in_widest_registers([=]() __attribute__((always_inline)) {
    split_pairs(colours, width, orders, cos, sin, spectra);
  });
}

void RowFft::texels_of_spectra(const RowPairs<const StoredLanes>& spectra, int orders,
                               const RowPairs<float>& texels, Scratch& scratch) const {
  prepare(scratch);
  const Colours colours{{scratch.re[0].data(), scratch.re[1].data(), scratch.re[2].data()},
                        {scratch.im[0].data(), scratch.im[1].data(), scratch.im[2].data()}};
  const int width = width_;
  const bool own_bins = 2 * (orders - 1) < width;
  const int first_free = own_bins ? orders : 0, free = own_bins ? width - 2 * orders + 1 : width;
  for (int c = 0; c < 3; ++c) {
    std::fill_n(colours.re[c] + first_free, free, Lanes{});
    std::fill_n(colours.im[c] + first_free, free, Lanes{});
  }
  const double *cos = centre_cos_.data(), *sin = centre_sin_.data();
  in_widest_registers([=]() __attribute__((always_inline)) {
    if (own_bins)
      join_pairs<true>(spectra, orders, width, cos, sin, colours);
    else
      join_pairs<false>(spectra, orders, width, cos, sin, colours);
  });
  // The inverse transform is the forward one with real and imaginary parts exchanged.
  for (int c = 0; c < 3; ++c) fft_.transform(colours.im[c], colours.re[c], scratch.work.data());
  in_widest_registers([=]() __attribute__((always_inline)) { scatter_texels(colours, width, texels); });
}

void RowFft::prepare(Scratch& scratch) const {
  for (int c = 0; c < 3; ++c) {
    scratch.re[c].resize(width_);
    scratch.im[c].resize(width_);
  }
  scratch.work.resize(2 * width_);
}

}  // namespace furnace
