// Small files of every format, made by libraries that the decoders under test do not use where there is one.
#pragma once

#include "renderer/image/image.hpp"
#include "renderer/base/blob.hpp"
#include "renderer/base/error.hpp"

#include <cstdint>
#include <random>
#include <string>
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

std::string rgbe_header(int width, int height);

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
