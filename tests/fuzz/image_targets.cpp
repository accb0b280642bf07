// Codecs of pictures.
#include <array>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/image/codecs.hpp"
#include "renderer/image/exr_parts.hpp"
#include "renderer/image/image_header.hpp"
#include "tests/fuzz/checked_decoder.hpp"
#include "tests/fuzz/mutators.hpp"

namespace furnace::fuzz {
namespace {

constexpr DecodeLimits kLimits = {.max_side_px = 512, .max_area_px = 1 << 16};

// Colour on or off by the input's size, so that a file stays a file.
ColorSpace color_space_of(Input file) {
  return file.size() % 2 == 0 ? ColorSpace::kSrgb : ColorSpace::kNonColor;
}

void expect_agreement(const ImageHeader& header, const DecodedTexture& texture) {
  const Image& first = texture.levels.at(0);
  const std::int64_t side = std::max(header.width, header.height);
  if (header.is_complete() && side <= kLimits.max_side_px)
    FURNACE_CHECK(first.extent == Extent({int(header.width), int(header.height)}), "{}: {}x{}, said {}x{}",
                  header.format, first.extent.width, first.extent.height, header.width, header.height);
  if (header.channels != 0)
    FURNACE_CHECK(first.channels == header.channels, "{}: {} channels, said {}", header.format,
                  first.channels, header.channels);
  if (header.bits != 0)
    FURNACE_CHECK(sample_bytes(first.type) * 8 == std::size_t(header.bits), "{}: {} bits said", header.format,
                  header.bits);
}

// The report's reader of headers looks at every file, the codec at those of its format.
template <ImageFormat kFormat>
void run_texture(Input file) {
  const auto header = read_image_header(file);
  const auto refusal = texture_refusal(file);
  if (sniff_image_format(file) != kFormat) return;
  const DecodedTexture texture = checked(decode::TextureJob{color_space_of(file), kLimits}, file);
  FURNACE_CHECK(!refusal, "decoded, but refused: {}", *refusal);
  FURNACE_CHECK(header, "{}: decoded, but its header is not known", image_format_name(kFormat));
  expect_agreement(*header, texture);
}

template <ImageFormat kFormat>
void run_environment(Input file) {
  if (sniff_image_format(file) != kFormat) return;
  // Any shape, as only one in many inputs would be twice as wide as high; then as it is used.
  if constexpr (kFormat == ImageFormat::kHdr) {
    decode_rgbe(file, kLimits, Shape::kAny);
  } else {
    decode_exr(file, kLimits, Shape::kAny);
  }
  checked(decode::EnvironmentJob{kLimits}, file);
}

void run_exr_parts(Input file) {
  const ExrParts parts = decode_exr_parts(file, kLimits);
  for (const auto& [name, image] : parts.images)
    FURNACE_CHECK(decode::is_whole(image, kLimits), "part {}: {}x{}", name, image.extent.width,
                  image.extent.height);
}

constexpr std::size_t kMostFileBytes = 16 << 10;

constexpr std::array kTargets = {
    Target{"png", run_texture<ImageFormat::kPng>, kMostFileBytes, mutate_png},
    Target{"jpeg", run_texture<ImageFormat::kJpeg>, kMostFileBytes, mutate_bytes},
    Target{"webp", run_texture<ImageFormat::kWebp>, kMostFileBytes, mutate_bytes},
    Target{"avif", run_texture<ImageFormat::kAvif>, kMostFileBytes, mutate_bytes},
    Target{"ktx2", run_texture<ImageFormat::kKtx2>, kMostFileBytes, mutate_bytes},
    Target{"hdr", run_environment<ImageFormat::kHdr>, kMostFileBytes, mutate_bytes},
    Target{"exr", run_environment<ImageFormat::kExr>, kMostFileBytes, mutate_bytes},
    Target{"exr_parts", run_exr_parts, kMostFileBytes, mutate_bytes},
};

}  // namespace

std::span<const Target> image_targets() {
  return kTargets;
}

}  // namespace furnace::fuzz
