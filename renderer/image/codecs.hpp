// One function per file format; only decode.cpp calls them. All check the extent in the header before they
// allocate.
#pragma once

#include "renderer/image/decode.hpp"
#include "renderer/image/image.hpp"

#include <cstddef>
#include <span>
#include <string_view>

namespace furnace {

// Textures are scaled down from here; what is longer is a mistake or worse.
inline constexpr int kMostSidePx = 65536;

enum class Shape { kAny, kEnvironment };

// Fails with kTooLarge, naming the limit that was broken; kUnprocessable for an environment that has no
// EnvironmentLayout.
void check_extent(std::string_view format, std::int64_t width, std::int64_t height,
                  const DecodeLimits& limits, Shape shape = Shape::kAny);

// Fails with kUnprocessable: "the PNG is damaged: ...".
[[noreturn]] void fail_damaged(std::string_view format, std::string_view what);

// Samples as glTF wants them: nothing but what is stored. Threads: any.
Image decode_png(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits);
Image decode_jpeg(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits);
Image decode_avif(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits);
Image decode_webp(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits);

// All levels from the first that is within the side's limit on, or the last alone where none is; RGBA. Threads: any.
DecodedTexture decode_ktx2(std::span<const std::byte> file, ColorSpace color_space,
                           const DecodeLimits& limits);
// Errors: kUnsupportedMedia for what decode_ktx2 does not read, by the header alone; others as there.
void check_ktx2_readable(std::span<const std::byte> file);

// RGB, kFloat32, exactly as stored: NaN, infinities and negative values included. Threads: any.
Image decode_rgbe(std::span<const std::byte> file, const DecodeLimits& limits,
                  Shape shape = Shape::kEnvironment);
Image decode_exr(std::span<const std::byte> file, const DecodeLimits& limits,
                 Shape shape = Shape::kEnvironment);

// The rules of decode_environment, on any RGB kFloat32 image.
RepairReport repair_radiance(Image& image);

}  // namespace furnace
