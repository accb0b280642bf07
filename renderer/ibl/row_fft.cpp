#include "renderer/ibl/row_fft.hpp"

#include <cmath>
#include <numbers>

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;

// A colour's real and imaginary parts of eight rows: rows in lanes.
struct Planes {
  Lanes re[3], im[3];

  [[gnu::always_inline]] void load(Lanes* const* rows, int m) {
    load(const_cast<const Lanes* const*>(rows), m);
  }
  [[gnu::always_inline]] void load(const Lanes* const* rows, int m) {
    Lanes block[8];
    for (int r = 0; r < 8; ++r) block[r] = rows[r][m];
    transpose(block);
    for (int c = 0; c < 3; ++c) re[c] = block[2 * c], im[c] = block[2 * c + 1];
  }
  [[gnu::always_inline]] void store(Lanes* const* rows, int m) const {
    Lanes block[8] = {re[0], im[0], re[1], im[1], re[2], im[2], Lanes{}, Lanes{}};
    transpose(block);
    for (int r = 0; r < 8; ++r) rows[r][m] = block[r];
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

[[gnu::always_inline]] inline void gather_texels(const RowPairs<const float>& texels, int width,
                                                 const Colours& out) {
  for (int i = 0; i < width; ++i) {
    for (int c = 0; c < 3; ++c) {
      double* re = reinterpret_cast<double*>(out.re[c] + i);
      double* im = reinterpret_cast<double*>(out.im[c] + i);
      for (int r = 0; r < 8; ++r) re[r] = texels.north[r][3 * i + c];
      for (int r = 0; r < 8; ++r) im[r] = texels.south[r][3 * i + c];
    }
  }
}

typedef float Floats __attribute__((vector_size(32)));

// Not below 0, as floats.
[[gnu::always_inline]] inline void store_clamped(const Lanes& lanes, float* out) {
  const Floats clamped = __builtin_convertvector(lanes.v > 0 ? lanes.v : Lanes::Vector{}, Floats);
  __builtin_memcpy(out, &clamped, sizeof(clamped));
}

[[gnu::always_inline]] inline void scatter_texels(const Colours& in, int width,
                                                  const RowPairs<float>& texels) {
  for (int i = 0; i < width; ++i) {
    float north[3][8], south[3][8];
    for (int c = 0; c < 3; ++c) {
      store_clamped(in.re[c][i], north[c]);
      store_clamped(in.im[c][i], south[c]);
    }
    for (int r = 0; r < 8; ++r)
      for (int c = 0; c < 3; ++c) texels.north[r][3 * i + c] = north[c][r];
    for (int r = 0; r < 8; ++r)
      for (int c = 0; c < 3; ++c) texels.south[r][3 * i + c] = south[c][r];
  }
}

// z = n + i s, w = conj(z of -m): n = (z + w) / 2, s = (z - w) / 2i
[[gnu::always_inline]] inline void split_pairs(const Colours& in, int width, int orders, const double* cos,
                                               const double* sin, const RowPairs<Lanes>& spectra) {
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

[[gnu::always_inline]] inline void join_pairs(const RowPairs<const Lanes>& spectra, int orders, int width,
                                              const double* cos, const double* sin, const Colours& out) {
  for (int m = 0; m < orders; ++m) {
    Planes north, south;
    north.load(spectra.north, m);
    south.load(spectra.south, m);
    const int phase = m % (2 * width), bin = m % width, mirror = bin == 0 ? 0 : width - bin;
    north.turn(cos[phase], sin[phase]);
    south.turn(cos[phase], sin[phase]);
    for (int c = 0; c < 3; ++c) {
      out.re[c][bin] += north.re[c] - south.im[c];
      out.im[c][bin] += north.im[c] + south.re[c];
      if (m == 0) continue;
      out.re[c][mirror] += north.re[c] + south.im[c];
      out.im[c][mirror] += south.re[c] - north.im[c];
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
                               const RowPairs<Lanes>& spectra, Scratch& scratch) const {
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

void RowFft::texels_of_spectra(const RowPairs<const Lanes>& spectra, int orders,
                               const RowPairs<float>& texels, Scratch& scratch) const {
  prepare(scratch);
  const Colours colours{{scratch.re[0].data(), scratch.re[1].data(), scratch.re[2].data()},
                        {scratch.im[0].data(), scratch.im[1].data(), scratch.im[2].data()}};
  const int width = width_;
  const double *cos = centre_cos_.data(), *sin = centre_sin_.data();
  for (int c = 0; c < 3; ++c) {
    std::fill_n(colours.re[c], width, Lanes{});
    std::fill_n(colours.im[c], width, Lanes{});
  }
  in_widest_registers([=]() __attribute__((always_inline)) {
    join_pairs(spectra, orders, width, cos, sin, colours);
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
