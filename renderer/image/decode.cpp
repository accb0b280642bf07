#include "renderer/image/decode.hpp"

#include "renderer/image/codecs.hpp"
#include "renderer/image/downscale.hpp"
#include "renderer/image/ktx2_container.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace furnace {

namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The three rows around the one being mended, as they were before anything was mended. Columns wrap around
// the sphere; there is no row beyond a pole.
class OriginalRows {
 public:
  explicit OriginalRows(const Image& image)
      : image_(image),
        stride_(static_cast<std::size_t>(image.extent.width) * 3),
        above_(stride_),
        here_(stride_) {}

  void enter(int y) {
    std::swap(above_, here_);
    std::ranges::copy(row(y), here_.begin());
    y_ = y;
  }

  // Mean of the finite ones among the eight neighbours, negative ones counting as 0; 0 when there is none.
  float mean_of_neighbours(int x, int channel) const {
    const std::span<const float> rows[] = {
        y_ > 0 ? above_ : std::span<const float>{}, here_,
        y_ + 1 < image_.extent.height ? row(y_ + 1) : std::span<const float>{}};
    const int width = image_.extent.width;
    double sum = 0;
    int count = 0;
    for (const auto& samples : rows) {
      if (samples.empty()) continue;
      for (int dx : {width - 1, 0, 1}) {
        const float sample = samples[static_cast<std::size_t>((x + dx) % width) * 3 + channel];
        if (!std::isfinite(sample)) continue;
        sum += std::max(sample, 0.0f);
        ++count;
      }
    }
    return count == 0 ? 0.0f : static_cast<float>(sum / count);
  }

 private:
  std::span<const float> row(int y) const {
    return image_.samples<float>().subspan(static_cast<std::size_t>(y) * stride_, stride_);
  }

  const Image& image_;
  const std::size_t stride_;
  std::vector<float> above_;
  std::vector<float> here_;
  int y_ = 0;
};

bool is_sound(float sample) {
  return sample >= 0 && sample <= std::numeric_limits<float>::max();
}

// Largest finite sample of each channel, 0 when there is none.
std::array<float, 3> finite_peaks(std::span<const float> samples) {
  std::array<float, 3> peaks{};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isfinite(samples[i])) peaks[i % 3] = std::max(peaks[i % 3], samples[i]);
  }
  return peaks;
}

// ISO/IEC 14496-12: the file type box names its brands.
bool is_avif(std::string_view text) {
  if (text.size() < 16 || text.substr(4, 4) != "ftyp") return false;
  const std::size_t size = std::size_t(std::uint8_t(text[2])) << 8 | std::uint8_t(text[3]);
  for (std::size_t at = 8; at + 4 <= std::min(size, text.size()); at += at == 8 ? 8 : 4) {
    if (text.substr(at, 4) == "avif") return true;
  }
  return false;
}

Image decode_picture(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits) {
  const ImageFormat format = sniff_image_format(file);
  switch (format) {
    case ImageFormat::kPng:
      return decode_png(file, color_space, limits);
    case ImageFormat::kJpeg:
      return decode_jpeg(file, color_space, limits);
    case ImageFormat::kWebp:
      return decode_webp(file, color_space, limits);
    case ImageFormat::kAvif:
      return decode_avif(file, color_space, limits);
    default:
      break;
  }
  fail(ErrorCode::kUnsupportedMedia, fmt::format("a texture is a {} file; the format of this one is {}",
                                                 kTextureFormats, image_format_name(format)));
}

}  // namespace

ImageFormat sniff_image_format(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  if (text.starts_with("\x89PNG\r\n\x1a\n")) return ImageFormat::kPng;
  if (text.starts_with("\xff\xd8\xff")) return ImageFormat::kJpeg;
  if (text.starts_with("RIFF") && text.size() >= 12 && text.substr(8, 4) == "WEBP") return ImageFormat::kWebp;
  if (is_avif(text)) return ImageFormat::kAvif;
  if (text.starts_with("\xabKTX 20\xbb\r\n\x1a\n")) return ImageFormat::kKtx2;
  if (text.starts_with("\x76\x2f\x31\x01")) return ImageFormat::kExr;
  if (text.starts_with("#?")) return ImageFormat::kHdr;
  return ImageFormat::kUnknown;
}

std::string_view image_format_name(ImageFormat format) {
  switch (format) {
    case ImageFormat::kPng:
      return "PNG";
    case ImageFormat::kJpeg:
      return "JPEG";
    case ImageFormat::kWebp:
      return "WebP";
    case ImageFormat::kAvif:
      return "AVIF";
    case ImageFormat::kKtx2:
      return "KTX2";
    case ImageFormat::kExr:
      return "OpenEXR";
    case ImageFormat::kHdr:
      return "Radiance HDR";
    case ImageFormat::kUnknown:
      break;
  }
  return "unknown";
}

bool is_texture_format(ImageFormat format) {
  switch (format) {
    case ImageFormat::kPng:
    case ImageFormat::kJpeg:
    case ImageFormat::kWebp:
    case ImageFormat::kAvif:
    case ImageFormat::kKtx2:
      return true;
    default:
      return false;
  }
}

void check_extent(std::string_view format, std::int64_t width, std::int64_t height,
                  const DecodeLimits& limits, Shape shape) {
  if (width < 1 || height < 1) fail_damaged(format, fmt::format("it claims {} x {} pixels", width, height));
  if (width > limits.max_side_px || height > limits.max_side_px) {
    fail(ErrorCode::kTooLarge, fmt::format("the {} has {} x {} pixels; a side may have {}", format, width,
                                           height, limits.max_side_px));
  }
  if (width * height > limits.max_area_px) {
    fail(ErrorCode::kTooLarge, fmt::format("the {} has {} x {} pixels; {} in all are allowed", format, width,
                                           height, limits.max_area_px));
  }
  if (shape == Shape::kAny) return;
  if (layout_of(width, height, EnvironmentLayout::kAuto) != EnvironmentLayout::kAuto) return;
  fail(ErrorCode::kUnprocessable,
       fmt::format(
           "an environment is an equirectangular map twice as wide as high, or a cube as a cross (4:3, 3:4) "
           "or a strip (6:1, 1:6), but this {} has {} x {} pixels; resample it to {} x {}",
           format, width, height, 2 * height, height));
}

void fail_damaged(std::string_view format, std::string_view what) {
  fail(ErrorCode::kUnprocessable, fmt::format("the {} is damaged: {}", format, what));
}

DecodedTexture decode_texture(std::span<const std::byte> file, ColorSpace color_space,
                              const DecodeLimits& limits) {
  const DecodeLimits loose{kMostSidePx, limits.max_area_px};
  DecodedTexture texture;
  Extent whole;
  if (sniff_image_format(file) == ImageFormat::kKtx2) {
    texture = decode_ktx2(file, color_space, limits);
    whole = open_ktx2(file, limits).levels.front().extent;
  } else {
    texture.levels.push_back(decode_picture(file, color_space, loose));
    whole = texture.levels[0].extent;
  }
  Image& largest = texture.levels[0];
  const Extent extent = fitted(largest.extent, limits.max_side_px);
  if (extent != largest.extent) largest = downscaled(largest, extent);
  if (extent == whole) return texture;
  texture.remarks.push_back(
      {"texture-downscaled", fmt::format("has {} x {} pixels and was scaled down to {} x {}", whole.width,
                                         whole.height, extent.width, extent.height)});
  return texture;
}

std::optional<std::string> texture_refusal(std::span<const std::byte> bytes) {
  const ImageFormat format = sniff_image_format(bytes);
  if (!is_texture_format(format)) return fmt::format("is not {}", kTextureFormats);
  if (format != ImageFormat::kKtx2) return std::nullopt;
  try {
    check_ktx2_readable(bytes);
  } catch (const Error& error) {
    if (error.code == ErrorCode::kUnsupportedMedia) return "cannot be read: " + error.message;
  }
  return std::nullopt;
}

RepairReport repair_radiance(Image& image) {
  const std::span<float> samples = image.samples<float>();
  RepairReport report;
  if (std::ranges::all_of(samples, is_sound)) return report;

  const std::array<float, 3> peaks = finite_peaks(samples);
  OriginalRows originals(image);
  float* sample = samples.data();
  for (int y = 0; y < image.extent.height; ++y) {
    originals.enter(y);
    for (int x = 0; x < image.extent.width; ++x) {
      for (int channel = 0; channel < 3; ++channel, ++sample) {
        if (is_sound(*sample)) continue;
        if (std::isnan(*sample)) {
          *sample = originals.mean_of_neighbours(x, channel);
          ++report.nan_samples;
        } else if (std::isinf(*sample)) {
          *sample = *sample > 0 ? peaks[channel] : 0.0f;
          ++report.infinite_samples;
        } else {
          *sample = 0;
          ++report.negative_samples;
        }
      }
    }
  }
  return report;
}

namespace {

EnvironmentLayout layout_in(const Extent& picture, EnvironmentLayout asked) {
  const EnvironmentLayout layout = layout_of(picture.width, picture.height, asked);
  if (layout != EnvironmentLayout::kAuto) return layout;
  const EnvironmentLayout found = layout_of(picture.width, picture.height, EnvironmentLayout::kAuto);
  fail(ErrorCode::kUnprocessable,
       fmt::format("{} x {} pixels are no {} but a {}; say so, or leave the layout to \"auto\"",
                   picture.width, picture.height, name_of(asked), name_of(found)));
}

// As the picture lies in its file -> as an equirect.
Image laid_out(Image picture, EnvironmentLayout layout, const DecodeLimits& limits) {
  if (layout == EnvironmentLayout::kEquirect) return picture;
  const int side = face_side(picture.extent, layout);
  check_extent("map that this cube gives", 4 * std::int64_t{side}, 2 * std::int64_t{side}, limits);
  return equirect_of_cube(picture, layout);
}

}  // namespace

DecodedEnvironment decode_environment(std::span<const std::byte> file, const DecodeLimits& limits,
                                      EnvironmentLayout layout) {
  Image picture;
  const ImageFormat format = sniff_image_format(file);
  switch (format) {
    case ImageFormat::kHdr:
      picture = decode_rgbe(file, limits);
      break;
    case ImageFormat::kExr:
      picture = decode_exr(file, limits);
      break;
    default:
      fail(ErrorCode::kUnsupportedMedia,
           fmt::format("an environment is a Radiance HDR or OpenEXR file; the format of this one is {}",
                       image_format_name(format)));
  }
  DecodedEnvironment environment;
  environment.layout = layout_in(picture.extent, layout);
  clear_beside_faces(picture, environment.layout);
  environment.repairs = repair_radiance(picture);
  environment.equirect = laid_out(std::move(picture), environment.layout, limits);
  return environment;
}

}  // namespace furnace
