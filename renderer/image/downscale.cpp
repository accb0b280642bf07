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

// Samples of type T <-> light in [0, 1], or data as they are.
template <class T>
class Codes {
 public:
  explicit Codes(bool srgb) : values_(std::size_t(kMost) + 1), nearest_(kBins + 1) {
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_[i] = float(srgb ? linear_from_srgb(double(i) / kMost) : double(i) / kMost);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double half = std::min((double(i) + 0.5) / kMost, 1.0);
      borders_.push_back(float(srgb ? linear_from_srgb(half) : half));
    }
    for (std::size_t bin = 0, code = 0; bin < nearest_.size(); ++bin) {
      while (code < std::size_t(kMost) && borders_[code] <= float(bin) / kBins) ++code;
      nearest_[bin] = T(code);
    }
  }

  float value(T code) const { return values_[code]; }
  // The code whose value, before it was rounded, is the closest.
  T code(float value) const {
    value = std::clamp(value, 0.0f, 1.0f);
    T code = nearest_[std::size_t(value * kBins)];
    while (code < T(kMost) && borders_[code] <= value) ++code;
    return code;
  }

 private:
  static constexpr double kMost = std::numeric_limits<T>::max();
  static constexpr float kBins = 4096;

  std::vector<float> values_, borders_;  // by code; a border is half way to the next code
  std::vector<T> nearest_;               // the lowest code of each bin of values
};

template <class T>
class Downscaler {
 public:
  Downscaler(const Image& source, Image& target)
      : source_(source),
        target_(target),
        color_(source.color_space == ColorSpace::kSrgb),
        data_(false),
        line_(std::size_t(source.extent.width) * std::size_t(source.channels)),
        narrowed_(std::size_t(target.extent.width) * std::size_t(source.channels)) {
    for (int x = 0; x < target.extent.width; ++x)
      columns_.push_back(cover_of(x, target.extent.width, source.extent.width));
  }

  void run() {
    std::vector<float> sum(narrowed_.size());
    for (int y = 0; y < target_.extent.height; ++y) {
      const Cover rows = cover_of(y, target_.extent.height, source_.extent.height);
      std::fill(sum.begin(), sum.end(), 0.0f);
      for (std::size_t i = 0; i < rows.weights.size(); ++i) {
        narrow(rows.first + int(i));
        for (std::size_t x = 0; x < sum.size(); ++x) sum[x] += rows.weights[i] * narrowed_[x];
      }
      const auto out = target_.samples<T>().subspan(std::size_t(y) * sum.size(), sum.size());
      for (std::size_t i = 0; i < sum.size(); ++i) out[i] = codes_of(i).code(sum[i]);
    }
  }

 private:
  // The last of two or four channels is alpha.
  const Codes<T>& codes_of(std::size_t sample) const {
    const auto channels = std::size_t(source_.channels);
    return channels % 2 == 0 && sample % channels == channels - 1 ? data_ : color_;
  }

  // Two target rows may share a source row.
  void narrow(int y) {
    if (y == narrowed_row_) return;
    narrowed_row_ = y;
    const auto channels = std::size_t(source_.channels);
    const auto samples = source_.samples<T>().subspan(std::size_t(y) * line_.size(), line_.size());
    for (std::size_t i = 0; i < line_.size(); ++i) line_[i] = codes_of(i).value(samples[i]);
    float* out = narrowed_.data();
    for (const Cover& cover : columns_) {
      const float* from = line_.data() + std::size_t(cover.first) * channels;
      for (std::size_t c = 0; c < channels; ++c, ++from, ++out) {
        *out = 0;
        for (std::size_t i = 0; i < cover.weights.size(); ++i) *out += cover.weights[i] * from[i * channels];
      }
    }
  }

  const Image& source_;
  Image& target_;
  const Codes<T> color_, data_;
  std::vector<Cover> columns_;
  std::vector<float> line_, narrowed_;
  int narrowed_row_ = -1;
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
