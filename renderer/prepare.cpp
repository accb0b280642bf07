#include "renderer/prepare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/ibl/baked_environment.hpp"
#include "renderer/image/color.hpp"

namespace furnace {
namespace {

// Grey -> RGB by repetition, absent alpha -> opaque.
template <class T>
Image expand_to_rgba(const Image& image, T opaque) {
  Image out = make_image(image.extent, 4, image.type, image.color_space);
  const auto source = image.samples<T>();
  const auto target = out.samples<T>();
  const auto channels = std::size_t(image.channels);
  const bool grey = channels <= 2, alpha = channels % 2 == 0;
  for (std::size_t i = 0, count = std::size_t(image.extent.area()); i < count; ++i) {
    const T* from = &source[i * channels];
    T* to = &target[i * 4];
    to[0] = from[0];
    to[1] = grey ? from[0] : from[1];
    to[2] = grey ? from[0] : from[2];
    to[3] = alpha ? from[channels - 1] : opaque;
  }
  return out;
}

// GL has no 16-bit sRGB texture: eight bits of the encoded value keep what sRGB promises.
Image narrow_to_8_bits(const Image& image) {
  Image out = make_image(image.extent, image.channels, SampleType::kUint8, image.color_space);
  const auto source = image.samples<std::uint16_t>();
  const auto target = out.samples<std::uint8_t>();
  for (std::size_t i = 0; i < source.size(); ++i) target[i] = std::uint8_t((source[i] + 128u) / 257u);
  return out;
}

Image to_uploadable(Image image, ColorSpace color_space) {
  if (image.type == SampleType::kUint16 && color_space == ColorSpace::kSrgb) image = narrow_to_8_bits(image);
  if (image.channels == 4) return image;
  return image.type == SampleType::kUint8 ? expand_to_rgba<std::uint8_t>(image, 255)
                                          : expand_to_rgba<std::uint16_t>(image, 65535);
}

template <class T>
float lowest_green_of(const Image& rgba) {
  const auto samples = rgba.samples<T>();
  T lowest = std::numeric_limits<T>::max();
  for (std::size_t i = 1; i < samples.size(); i += 4) lowest = std::min(lowest, samples[i]);
  return float(lowest) / float(std::numeric_limits<T>::max());
}

float lowest_green(const Image& rgba) {
  return rgba.type == SampleType::kUint8 ? lowest_green_of<std::uint8_t>(rgba)
                                         : lowest_green_of<std::uint16_t>(rgba);
}

Image white_pixel() {
  Image image = make_image({1, 1}, 4, SampleType::kUint8, ColorSpace::kNonColor);
  std::fill(image.pixels.begin(), image.pixels.end(), std::byte{255});
  return image;
}

// The largest power of two that brings `peak` to at most 2^15, so that bilinear sums stay finite too.
double half_scale(double peak) {
  constexpr double kLargest = 32768;
  return peak <= kLargest ? 1.0 : std::exp2(std::floor(std::log2(kLargest / peak)));
}

}  // namespace

PreparedPixels prepare_texture(Decoder& decoder, const Blob& encoded, ColorSpace color_space,
                               const std::string& pointer, const DecodeLimits& limits,
                               const Deadline& deadline) {
  PreparedPixels prepared;
  try {
    DecodedTexture decoded = decoder.texture(encoded, color_space, limits, deadline);
    prepared.lowest_green = 1;
    for (Image& level : decoded.levels) {
      prepared.levels.push_back(to_uploadable(std::move(level), color_space));
      prepared.lowest_green = std::min(prepared.lowest_green, lowest_green(prepared.levels.back()));
    }
    for (TextureRemark& remark : decoded.remarks)
      prepared.notes.push_back({std::move(remark.code), pointer, std::move(remark.message)});
  } catch (Error& error) {
    error.pointer = pointer;
    if (error.code != ErrorCode::kUnsupportedMedia) throw;
    prepared = {{white_pixel()}, 1, {}};
    prepared.notes.push_back({"texture-unsupported", pointer, error.message + "; white stands in for it"});
  }
  return prepared;
}

PreparedSky prepare_sky(const Image& radiance, const ContentHash& key, WorkerPool& pool) {
  const auto source = radiance.samples<float>();
  PreparedSky sky;
  sky.key = key;
  sky.texels = make_image(radiance.extent, 4, SampleType::kFloat16, ColorSpace::kLinear);
  sky.scale = half_scale(double(*std::max_element(source.begin(), source.end())));
  const auto target = sky.texels.samples<std::uint16_t>();
  const auto width = std::size_t(radiance.extent.width);
  const auto scale = float(sky.scale);
  constexpr double kRowCostUs = 20;
  pool.parallel_for(std::size_t(radiance.extent.height), kRowCostUs, [&](std::size_t y) {
    for (std::size_t i = y * width; i < (y + 1) * width; ++i) {
      for (std::size_t c = 0; c < 3; ++c) target[i * 4 + c] = half_from_float(source[i * 3 + c] * scale);
      target[i * 4 + 3] = 0x3c00;  // 1.0
    }
  });
  return sky;
}

PreparedEnvironment prepare_environment(Image radiance, bool extracts_suns, const ContentHash& key,
                                        WorkerPool& pool, const Deadline& deadline,
                                        const BakeProgress& progress) {
  PreparedEnvironment out;
  EnvironmentSummary& summary = out.summary;
  out.key = key;
  summary.suns = find_suns(radiance, deadline);
  summary.suns_extracted = extracts_suns && !summary.suns.empty();
  if (summary.suns_extracted) {
    out.map = prepare_sky(radiance, map_key_of(key), pool);
    SunExtraction extraction = extract_suns(radiance, deadline);
    summary.suns = std::move(extraction.suns);
    radiance = std::move(extraction.residual);
  }
  const auto shared = std::make_shared<const Image>(std::move(radiance));
  const auto baked = bake_environment(shared, key, pool, deadline, {.progress = progress});
  out.atlas = make_octahedral_atlas(*baked, pool);
  out.sky = prepare_sky(*shared, key, pool);
  summary.size = shared->extent;
  summary.mean = baked->mean;
  summary.peak = baked->peak;
  summary.horizontal_illuminance_lux = horizontal_illuminance_lux(*baked);
  summary.bake_ms = baked->bake_ms;
  if (summary.suns_extracted) {
    for (const Sun& sun : summary.suns) {
      for (std::size_t c = 0; c < 3; ++c) summary.mean[c] += sun.irradiance[c] / (4 * std::numbers::pi);
      summary.peak = std::max(summary.peak, sun.peak);
      summary.horizontal_illuminance_lux +=
          luminance_rec709(sun.irradiance[0], sun.irradiance[1], sun.irradiance[2]) *
          std::max(sun.direction[1], 0.0);
    }
  }
  return out;
}

}  // namespace furnace
