#include "renderer/image/downscale.hpp"

#include "renderer/base/check.hpp"
#include "renderer/image/color.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace furnace {

namespace {

// How much of source pixel `first + i` a target pixel covers; all weights sum to 1.
struct Cover {
  int first = 0;
  std::vector<float> weights;
};

Cover cover_of(int target, int targets, int sources) {
  const double scale = double(sources) / targets, low = target * scale,
               high = std::min((target + 1) * scale, double(sources));
  Cover cover;
  cover.first = int(low);
  for (int i = cover.first; i < high && i < sources; ++i)
    cover.weights.push_back(float((std::min(high, i + 1.0) - std::max(low, double(i))) / scale));
  return cover;
}

template <class T>
class Downscaler {
 public:
  Downscaler(const Image& source, Image& target) : source_(source), target_(target) {
    constexpr double kMost = std::numeric_limits<T>::max();
    const bool srgb = source.color_space == ColorSpace::kSrgb;
    linear_.resize(std::size_t(kMost) + 1);
    for (std::size_t i = 0; i < linear_.size(); ++i)
      linear_[i] = float(srgb ? linear_from_srgb(double(i) / kMost) : double(i) / kMost);
    // The last of two or four channels is alpha.
    alpha_ = source.channels % 2 == 0 ? source.channels - 1 : source.channels;
    for (int x = 0; x < target.extent.width; ++x)
      columns_.push_back(cover_of(x, target.extent.width, source.extent.width));
  }

  void run() {
    const std::size_t width = std::size_t(target_.extent.width) * std::size_t(source_.channels);
    std::vector<float> row(width), sum(width);
    for (int y = 0; y < target_.extent.height; ++y) {
      const Cover rows = cover_of(y, target_.extent.height, source_.extent.height);
      std::fill(sum.begin(), sum.end(), 0.0f);
      for (std::size_t i = 0; i < rows.weights.size(); ++i) {
        narrow(rows.first + int(i), row);
        for (std::size_t x = 0; x < width; ++x) sum[x] += rows.weights[i] * row[x];
      }
      store(y, sum);
    }
  }

 private:
  float light(T sample, int channel) const {
    return channel == alpha_ ? float(sample) / float(std::numeric_limits<T>::max()) : linear_[sample];
  }

  void narrow(int y, std::vector<float>& out) const {
    const auto channels = std::size_t(source_.channels);
    const auto samples =
        source_.samples<T>().subspan(std::size_t(y) * std::size_t(source_.extent.width) * channels);
    for (std::size_t x = 0; x < columns_.size(); ++x) {
      const Cover& cover = columns_[x];
      for (std::size_t c = 0; c < channels; ++c) {
        float mean = 0;
        for (std::size_t i = 0; i < cover.weights.size(); ++i)
          mean += cover.weights[i] * light(samples[(std::size_t(cover.first) + i) * channels + c], int(c));
        out[x * channels + c] = mean;
      }
    }
  }

  void store(int y, const std::vector<float>& row) {
    constexpr double kMost = std::numeric_limits<T>::max();
    const auto out = target_.samples<T>().subspan(std::size_t(y) * row.size(), row.size());
    const bool srgb = source_.color_space == ColorSpace::kSrgb;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const double value = std::clamp(double(row[i]), 0.0, 1.0);
      const bool is_light = srgb && int(i % std::size_t(source_.channels)) != alpha_;
      out[i] = T(std::lround((is_light ? srgb_from_linear(value) : value) * kMost));
    }
  }

  const Image& source_;
  Image& target_;
  std::vector<float> linear_;  // by code
  std::vector<Cover> columns_;
  int alpha_ = 0;
};

}  // namespace

Image downscaled(const Image& image, Extent extent) {
  FURNACE_CHECK(extent.width <= image.extent.width && extent.height <= image.extent.height,
                "{} x {} from {} x {}", extent.width, extent.height, image.extent.width, image.extent.height);
  FURNACE_CHECK(image.type == SampleType::kUint8 || image.type == SampleType::kUint16, "sample type {}",
                int(image.type));
  Image result = make_image(extent, image.channels, image.type, image.color_space);
  if (image.type == SampleType::kUint8) {
    Downscaler<std::uint8_t>(image, result).run();
  } else {
    Downscaler<std::uint16_t>(image, result).run();
  }
  return result;
}

Extent fitted(Extent extent, int side_px) {
  const int longest = std::max(extent.width, extent.height);
  if (longest <= side_px) return extent;
  const auto side = [&](int px) {
    return std::clamp(int(std::lround(double(px) * side_px / longest)), 1, side_px);
  };
  return {side(extent.width), side(extent.height)};
}

}  // namespace furnace
