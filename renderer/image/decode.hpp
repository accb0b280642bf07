// Encoded bytes -> Image, one codec per format (codecs.hpp); nothing is trusted before the header was checked.
#pragma once

#include "renderer/image/image.hpp"
#include "renderer/base/blob.hpp"

#include <cstdint>
#include <string_view>

namespace furnace {

struct DecodeLimits {
  int max_side_px = 16384;
  std::int64_t max_area_px = 50'000'000;
};

enum class ImageFormat { kUnknown, kPng, kJpeg, kWebp, kExr, kHdr };

// By magic number, never by name.
ImageFormat sniff_image_format(std::span<const std::byte> bytes);
std::string_view image_format_name(ImageFormat format);  // "PNG", ...
bool is_texture_format(ImageFormat format);              // what decode_texture reads: PNG, JPEG, WebP

// PNG, JPEG (and WebP) for material textures: 8-bit or 16-bit samples, 1..4 channels as stored (palettes
// expanded, CMYK converted), gamma and EXIF orientation ignored as glTF asks. `color_space` is what the
// texture slot says. Errors: kUnsupportedMedia (not such a file), kTooLarge (limits), kUnprocessable
// (damaged). Threads: any.
Image decode_texture(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits);

// What was mended in an HDRI before use; all zero for a clean file.
struct RepairReport {
  bool operator==(const RepairReport&) const = default;

  std::int64_t nan_samples = 0;
  std::int64_t infinite_samples = 0;
  std::int64_t negative_samples = 0;
};

struct DecodedEnvironment {
  Image equirect;  // RGB, kFloat32, kLinear, every sample finite and >= 0; aspect 2:1
  RepairReport repairs;
};

// .hdr (RGBE, all RLE variants) and .exr (half/float/uint, scanline/tiled/mip-mapped, first part, data window
// filled into display window) equirects. NaN -> mean of valid neighbours (0 without any), +inf -> largest
// finite value of that channel, negative and -inf -> 0; counted in `repairs`. Errors as decode_texture;
// kUnprocessable for an aspect ratio other than 2:1, saying what to do.
DecodedEnvironment decode_environment(std::span<const std::byte> file, const DecodeLimits& limits);

}  // namespace furnace
