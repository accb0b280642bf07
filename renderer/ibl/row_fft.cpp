#include "renderer/ibl/row_fft.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace furnace {

namespace {

constexpr double kPi = std::numbers::pi;

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

void RowFft::prepare(Scratch& scratch) const {
  scratch.re.assign(width_, {});
  scratch.im.assign(width_, {});
  scratch.work.resize(2 * width_);
}

void RowFft::spectra_of_texels(const Rows<const float>& texels, const Rows<Lanes>& spectra, Scratch& scratch) const {
  prepare(scratch);
  Lanes *re = scratch.re.data(), *im = scratch.im.data();
  const std::vector<float> dark(texels.north.back() && texels.south.back() ? 0 : 3 * width_);  // for absent rows
  Rows<const float> rows = texels;
  for (int r = 0; r < kPairs; ++r) {
    if (!rows.north[r]) rows.north[r] = dark.data();
    if (!rows.south[r]) rows.south[r] = dark.data();
  }
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < width_; ++i) {
      for (int r = 0; r < kPairs; ++r) re[i].set(r, rows.north[r][3 * i + c]);
      for (int r = 0; r < kPairs; ++r) im[i].set(r, rows.south[r][3 * i + c]);
    }
    fft_.transform(re, im, scratch.work.data());
    for (int m = 0; m <= width_ / 2; ++m) {
      const int mirror = m == 0 ? 0 : width_ - m;
      // z = n + i s, w = conj(z of -m): n = (z + w) / 2, s = (z - w) / 2i
      const Lanes north_re = 0.5 * (re[m] + re[mirror]), north_im = 0.5 * (im[m] - im[mirror]);
      const Lanes south_re = 0.5 * (im[m] + im[mirror]), south_im = 0.5 * (re[mirror] - re[m]);
      const double cos = box_cos_[m], sin = box_sin_[m];
      const Lanes n_re = cos * north_re - sin * north_im, n_im = cos * north_im + sin * north_re;
      const Lanes s_re = cos * south_re - sin * south_im, s_im = cos * south_im + sin * south_re;
      for (int r = 0; r < kPairs; ++r) {
        if (spectra.north[r]) spectra.north[r][m].set(2 * c, n_re[r]), spectra.north[r][m].set(2 * c + 1, n_im[r]);
        if (spectra.south[r]) spectra.south[r][m].set(2 * c, s_re[r]), spectra.south[r][m].set(2 * c + 1, s_im[r]);
      }
    }
  }
}

void RowFft::texels_of_spectra(const Rows<const Lanes>& spectra, int orders, const Rows<float>& texels,
                               Scratch& scratch) const {
  for (int c = 0; c < 3; ++c) {
    prepare(scratch);
    Lanes *re = scratch.re.data(), *im = scratch.im.data();
    for (int m = 0; m < orders; ++m) {
      Lanes north_re, north_im, south_re, south_im;
      for (int r = 0; r < kPairs; ++r) {
        if (const Lanes* row = spectra.north[r]) north_re.set(r, row[m][2 * c]), north_im.set(r, row[m][2 * c + 1]);
        if (const Lanes* row = spectra.south[r]) south_re.set(r, row[m][2 * c]), south_im.set(r, row[m][2 * c + 1]);
      }
      const double cos = centre_cos_[m % (2 * width_)], sin = centre_sin_[m % (2 * width_)];
      const Lanes n_re = cos * north_re - sin * north_im, n_im = cos * north_im + sin * north_re;
      const Lanes s_re = cos * south_re - sin * south_im, s_im = cos * south_im + sin * south_re;
      const int bin = m % width_;
      re[bin] += n_re - s_im;
      im[bin] += n_im + s_re;
      if (m == 0) continue;
      const int mirror = bin == 0 ? 0 : width_ - bin;
      re[mirror] += n_re + s_im;
      im[mirror] += s_re - n_im;
    }
    fft_.transform(im, re, scratch.work.data());
    for (int i = 0; i < width_; ++i) {
      for (int r = 0; r < kPairs; ++r) {
        if (texels.north[r]) texels.north[r][3 * i + c] = static_cast<float>(std::max(0.0, re[i][r]));
        if (texels.south[r]) texels.south[r][3 * i + c] = static_cast<float>(std::max(0.0, im[i][r]));
      }
    }
  }
}

}  // namespace furnace
