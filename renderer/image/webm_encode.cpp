// Video for browsers: VP9, and alpha as a second stream beside each frame (RFC 9559, 2024: AlphaMode).
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "renderer/base/check.hpp"
#include "renderer/image/encode.hpp"
#include "renderer/image/vp9_stream.hpp"
#include "renderer/image/webm_container.hpp"

namespace furnace {
namespace {

constexpr int kColors = 3, kWithAlpha = 4;
// A player that seeks decodes from the key before, at most so much.
constexpr double kKeyInterval_s = 5;

// Behind what is transparent lies no colour, but the codec would let black run into the edge: each block of its transform gets
// the mean of what is visible in it, or else the colour of the block before.
Image with_flat_background(Image image) {
  constexpr int kBlockPx = 8;
  const auto samples = image.samples<std::uint8_t>();
  std::array<std::uint8_t, kColors> fill = {};
  const auto for_each_px = [&](int x0, int y0, const auto& visit) {
    for (int y = y0; y < std::min(y0 + kBlockPx, image.extent.height); ++y)
      for (int x = x0; x < std::min(x0 + kBlockPx, image.extent.width); ++x)
        visit(samples.data() +
              (std::size_t(y) * std::size_t(image.extent.width) + std::size_t(x)) * kWithAlpha);
  };
  for (int y0 = 0; y0 < image.extent.height; y0 += kBlockPx) {
    for (int x0 = 0; x0 < image.extent.width; x0 += kBlockPx) {
      std::array<int, kWithAlpha> sum = {};
      for_each_px(x0, y0, [&](const std::uint8_t* px) {
        for (std::size_t c = 0; c < kColors; ++c) sum[c] += px[c] * px[kColors];
        sum[kColors] += px[kColors];
      });
      for (std::size_t c = 0; c < kColors && sum[kColors] > 0; ++c)
        fill[c] = static_cast<std::uint8_t>((sum[c] + sum[kColors] / 2) / sum[kColors]);
      for_each_px(x0, y0, [&](std::uint8_t* px) {
        if (px[kColors] == 0) std::copy(fill.begin(), fill.end(), px);
      });
    }
  }
  return image;
}

std::uint8_t rounded(float value) {
  return static_cast<std::uint8_t>(value + 0.5f);
}

// ITU-R BT.709-6 (2015), sections 3.2 to 3.4, of 8 bits.
constexpr float kRed = 0.2126f, kGreen = 0.7152f, kBlue = 0.0722f;
float luma(const float* rgb) {
  return kRed * rgb[0] + kGreen * rgb[1] + kBlue * rgb[2];
}

YuvPlanes yuv_of(const Image& image) {
  const int width = image.extent.width, height = image.extent.height;
  const Extent half = chroma_extent(image.extent);
  YuvPlanes planes{image.extent, {}, {}, {}};
  planes.y.reserve(std::size_t(image.extent.area()));
  planes.cb.reserve(std::size_t(half.area()));
  planes.cr.reserve(std::size_t(half.area()));
  const auto samples = image.samples<std::uint8_t>();
  const auto at = [&](int x, int y) {
    return samples.data() +
           (std::size_t(y) * std::size_t(width) + std::size_t(x)) * std::size_t(image.channels);
  };
  constexpr float kLumaSteps = 219.f / 255, kChromaSteps = 224.f / 255, kLumaBlack = 16, kGrey = 128;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* px = at(x, y);
      const float rgb[] = {float(px[0]), float(px[1]), float(px[2])};
      planes.y.push_back(rounded(kLumaBlack + kLumaSteps * luma(rgb)));
    }
  // Chroma lies upon the left of two columns and between two rows.
  constexpr float kColumnWeights[] = {0.25f, 0.5f, 0.25f};
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      float rgb[kColors] = {};
      for (int row = 0; row < 2; ++row)
        for (int column = -1; column <= 1; ++column) {
          const std::uint8_t* px =
              at(std::clamp(2 * x + column, 0, width - 1), std::min(2 * y + row, height - 1));
          for (int c = 0; c < kColors; ++c) rgb[c] += 0.5f * kColumnWeights[column + 1] * float(px[c]);
        }
      const float bright = luma(rgb);
      planes.cb.push_back(rounded(kGrey + kChromaSteps * (rgb[2] - bright) / (2 * (1 - kBlue))));
      planes.cr.push_back(rounded(kGrey + kChromaSteps * (rgb[0] - bright) / (2 * (1 - kRed))));
    }
  return planes;
}

// Alpha as luma of full range without chroma.
YuvPlanes alpha_of(const Image& image) {
  constexpr std::uint8_t kNone = 128;
  const auto chroma_px = std::size_t(chroma_extent(image.extent).area());
  YuvPlanes planes{image.extent, {}, std::vector(chroma_px, kNone), std::vector(chroma_px, kNone)};
  const auto samples = image.samples<std::uint8_t>();
  for (std::size_t i = kColors; i < samples.size(); i += kWithAlpha) planes.y.push_back(samples[i]);
  return planes;
}

class WebmVideo final : public AnimationEncoder {
 public:
  WebmVideo(const AnimationTiming& timing, int quality, std::vector<TextField> metadata)
      : timing_(timing),
        settings_{quality, std::max(1, static_cast<int>(kKeyInterval_s * timing.frames_per_second)),
                  timing.frames_per_second},
        metadata_(std::move(metadata)) {}

  void add(const Image& frame) override {
    FURNACE_CHECK(
        frame.type == SampleType::kUint8 && (frame.channels == kColors || frame.channels == kWithAlpha),
        "a WebM of {} channels, sample type {}", frame.channels, static_cast<int>(frame.type));
    if (!color_) {
      extent_ = frame.extent;
      color_.emplace(extent_, settings_);
      if (frame.channels == kWithAlpha) alpha_.emplace(extent_, settings_);
    }
    FURNACE_CHECK(alpha_.has_value() == (frame.channels == kWithAlpha), "{} channels", frame.channels);
    color_->add(yuv_of(alpha_ ? with_flat_background(frame) : frame));
    if (alpha_) alpha_->add(alpha_of(frame));
    ++added_;
  }

  std::string finish() override {
    FURNACE_CHECK(added_ == timing_.frames, "{} frames of {}", added_, timing_.frames);
    const std::vector<Vp9Frame> color = color_->finish();
    const std::vector<Vp9Frame> alpha = alpha_ ? alpha_->finish() : std::vector<Vp9Frame>();
    return webm_file(extent_, timing_, color, alpha, metadata_);
  }

 private:
  const AnimationTiming timing_;
  const Vp9Settings settings_;
  const std::vector<TextField> metadata_;
  Extent extent_;
  std::optional<Vp9Stream> color_, alpha_;
  int added_ = 0;
};

}  // namespace

std::unique_ptr<AnimationEncoder> webm_video(const AnimationTiming& timing, int quality,
                                             const std::vector<TextField>& metadata) {
  return std::make_unique<WebmVideo>(timing, quality, metadata);
}

}  // namespace furnace
