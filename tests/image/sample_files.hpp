// Small files of every format, made by libraries that the decoders under test do not use where there is one.
#pragma once

#include "renderer/image/decode.hpp"
#include "renderer/image/image.hpp"
#include "renderer/base/blob.hpp"
#include "renderer/base/error.hpp"

#include <OpenEXR/ImfCompression.h>

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace furnace::sample {

// Same seed, same noise, everywhere (std::uniform_int_distribution is not the same everywhere).
inline std::uint32_t next(std::mt19937& random, std::uint32_t below) {
  return static_cast<std::uint32_t>(random() % below);
}

std::vector<std::uint8_t> noise(std::size_t size, std::uint32_t seed);

struct PngOptions {
  int color_type = 2;
  int depth = 8;
  bool interlaced = false;
  int filters = 0xf8;             // PNG_ALL_FILTERS, or one of libpng's masks
  std::string palette = {};       // RGB triples
  std::string transparency = {};  // alphas of a palette, or big-endian 16-bit samples of the key colour
};

// `rows` as stored: packed below 8 bits, big-endian at 16. By libpng.
std::string png(int width, int height, const std::vector<std::uint8_t>& rows, const PngOptions& options);

enum class JpegKind { kGrey, kRgb, kProgressive, kCmyk, kAdobeCmyk };
// One colour everywhere, in the samples of its kind. By libjpeg at quality 100.
std::string flat_jpeg(int width, int height, const std::vector<std::uint8_t>& color, JpegKind kind);

std::string lossless_webp(int width, int height, int channels, const std::vector<std::uint8_t>& samples);

// `samples` of 8 bits, or of 10 or 12 little-endian in 16. By libavif, RGB kept as it is.
std::string lossless_avif(int width, int height, int channels, int depth,
                          const std::vector<std::uint8_t>& samples);
// With half as many samples of colour each way, as photographs have.
std::string subsampled_avif(int width, int height, int channels, const std::vector<std::uint8_t>& samples);

std::string rgbe_header(int width, int height);

// Half floats of R, G and B, 24x12 px. By OpenEXR.
std::string small_exr(Imf::Compression compression, bool is_tiled);

// A wrong checksum hides everything behind it: `png` with right ones of its chunks, as far as it has chunks.
std::string with_right_checksums(std::string png);

// A file that holds one picture, decoded as a texture.
inline Image picture(const std::string& file, ColorSpace color_space, const DecodeLimits& limits = {}) {
  return std::move(decode_texture(Blob(file), color_space, limits).levels.at(0));
}

// Runs `body`, which must fail with an Error.
template <class Body>
Error error_of(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    return error;
  }
  Error none;
  none.message = "(nothing was thrown)";
  return none;
}

}  // namespace furnace::sample
