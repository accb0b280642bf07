#include "renderer/frame/pixel_filter.hpp"

#include <algorithm>
#include <cmath>

#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

// Less its value at the radius, so that it ends without a step.
double gaussian(double x) {
  constexpr double kSigma = 1.0 / 3;
  const auto bell = [](double at) { return std::exp(-at * at / (2 * kSigma * kSigma)); };
  return bell(x) - bell(1);
}

// Harris 1978, "On the Use of Windows for Harmonic Analysis with the Discrete Fourier Transform": minimum 4-sample window.
double blackman_harris(double x) {
  return 0.35875 + 0.48829 * std::cos(kPi * x) + 0.14128 * std::cos(2 * kPi * x) +
         0.01168 * std::cos(3 * kPi * x);
}

// Mitchell and Netravali 1988, "Reconstruction Filters in Computer Graphics", eq. 8 with B = C = 1/3.
double mitchell(double x) {
  constexpr double kB = 1.0 / 3, kC = 1.0 / 3;
  const double t = 2 * x;
  if (t < 1) return ((12 - 9 * kB - 6 * kC) * t * t * t + (-18 + 12 * kB + 6 * kC) * t * t + 6 - 2 * kB) / 6;
  return ((-kB - 6 * kC) * t * t * t + (6 * kB + 30 * kC) * t * t + (-12 * kB - 48 * kC) * t + 8 * kB +
          24 * kC) /
         6;
}

// Of the filter's absolute value, from the middle outwards: the share within each of so many steps.
class HalfDistribution {
 public:
  explicit HalfDistribution(const PixelFilter& filter) : radius_px_(filter.radius_px) {
    double sum = 0, negative = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double value = filter_value(filter, (i + 0.5) * radius_px_ / kSteps);
      sum += std::abs(value);
      negative += std::max(-value, 0.0);
      within_[std::size_t(i) + 1] = sum;
    }
    for (double& share : within_) share /= sum;
    const double all = sum - 2 * negative, along = negative / all, across = (sum - negative) / all;
    negative_ = 2 * along * across;
  }

  // Of the filter along both axes, what is below zero; the rest is more than 1 by as much.
  double negative() const { return negative_; }

  // The place below which the share `u` of [-0.5, 0.5) lies, px.
  double place(double u) const {
    const double share = std::min(2 * std::abs(u), 1.0);
    const auto* above = std::upper_bound(within_, within_ + kSteps, share);
    const auto step = double(above - within_ - 1);
    const double along = (share - above[-1]) / (*above - above[-1]);
    return std::copysign((step + along) * radius_px_ / kSteps, u);
  }

 private:
  static constexpr int kSteps = 1024;
  double radius_px_;
  double negative_ = 0;
  double within_[kSteps + 1] = {};
};

}  // namespace

double filter_value(const PixelFilter& filter, double offset_px) {
  const double x = std::abs(offset_px) / filter.radius_px;
  if (!(x < 1)) return 0;
  switch (filter.kind) {
    case PixelFilterKind::kBox:
      return 1;
    case PixelFilterKind::kGaussian:
      return gaussian(x);
    case PixelFilterKind::kBlackmanHarris:
      return blackman_harris(x);
    case PixelFilterKind::kMitchell:
      return mitchell(x);
  }
  return 0;
}

// Ernst, Stamminger and Greiner 2006, "Filter Importance Sampling": with it every sub-frame of one sign counts alike.
std::vector<float> warp_by_filter(const PixelFilter& filter, std::vector<glm::vec2>& places) {
  std::vector<float> weights(places.size(), 1);
  double negative = 0;
  if (filter.kind == PixelFilterKind::kBox) {
    for (glm::vec2& place : places) place *= float(2 * filter.radius_px);
  } else if (filter.radius_px > 0) {
    const HalfDistribution distribution(filter);
    negative = distribution.negative();
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double x = distribution.place(places[i].x), y = distribution.place(places[i].y);
      if (filter_value(filter, x) * filter_value(filter, y) < 0) weights[i] = -1;
      places[i] = {float(x), float(y)};
    }
  } else {
    std::fill(places.begin(), places.end(), glm::vec2(0));
  }
  // Those of either sign come to what the filter has of it, however few they are: one of eight in a lobe of a sixteenth would
  // take twice what the filter does.
  const auto lobes = double(std::count(weights.begin(), weights.end(), -1.f));
  const double others = double(weights.size()) - lobes;
  if (lobes == 0 || others == 0) {
    std::fill(weights.begin(), weights.end(), float(1 / double(weights.size())));
    return weights;
  }
  for (float& weight : weights) weight = float(weight < 0 ? -negative / lobes : (1 + negative) / others);
  return weights;
}

}  // namespace furnace
