// Encoded bytes -> pixels, one codec per format (codecs.hpp); nothing is trusted before the header was checked.
#pragma once

#include "renderer/image/environment_layout.hpp"
#include "renderer/image/image.hpp"
#include "renderer/base/blob.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace furnace {

struct DecodeLimits {
  int max_side_px = 16384;
  std::int64_t max_area_px = 50'000'000;
};

enum class ImageFormat { kUnknown, kPng, kJpeg, kWebp, kAvif, kKtx2, kExr, kHdr };

// By magic number, never by name.
ImageFormat sniff_image_format(std::span<const std::byte> bytes);
std::string_view image_format_name(ImageFormat format);  // "PNG", ...
bool is_texture_format(ImageFormat format);              // what decode_texture reads
inline constexpr std::string_view kTextureFormats = "PNG, JPEG, WebP, AVIF or KTX2";

// Something of a texture that was not taken as it is stored.
struct TextureRemark {
  std::string code;     // stable, kebab-case, as Note::code
  std::string message;  // goes on after "the texture"
};

struct DecodedTexture {
  // The largest first, each half as large as the one before, rounded down; at least one.
  std::vector<Image> levels;
  std::vector<TextureRemark> remarks;
};

// For material textures: 8-bit or 16-bit samples, 1..4 channels as stored (palettes expanded, CMYK converted), gamma
// and EXIF orientation ignored as glTF asks. `color_space` is what the texture slot says. A picture within the area
// but with a longer side than the limits have is scaled down. Errors: kUnsupportedMedia (not such a file), kTooLarge
// (limits), kUnprocessable (damaged). Threads: any.
DecodedTexture decode_texture(std::span<const std::byte> file, ColorSpace color_space,
                              const DecodeLimits& limits);

// Why a file is no texture, as far as its beginning tells: none for one that decode_texture reads or finds damaged.
// Goes on after "the image". Threads: any.
std::optional<std::string> texture_refusal(std::span<const std::byte> bytes);

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
  EnvironmentLayout layout = EnvironmentLayout::kEquirect;  // of the file; not kAuto
};

// .hdr (RGBE, all RLE variants) and .exr (half/float/uint, scanline/tiled/mip-mapped, first part, data window
// filled into display window) equirects, or cubes, which become equirects four faces wide. NaN -> mean of valid neighbours (0 without any), +inf -> largest
// finite value of that channel, negative and -inf -> 0; counted in `repairs`. Errors as decode_texture;
// kUnprocessable for an aspect ratio other than that of `layout` or, for kAuto, of any, saying what to do.
DecodedEnvironment decode_environment(std::span<const std::byte> file, const DecodeLimits& limits,
                                      EnvironmentLayout layout = EnvironmentLayout::kAuto);

}  // namespace furnace
