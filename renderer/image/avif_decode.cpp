#include "renderer/image/codecs.hpp"
#include "renderer/base/error.hpp"

#include <avif/avif.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "AVIF";

using Decoder = std::unique_ptr<avifDecoder, decltype(&avifDecoderDestroy)>;

void check(avifResult result) {
  if (result == AVIF_RESULT_OK) return;
  if (result == AVIF_RESULT_NOT_IMPLEMENTED || result == AVIF_RESULT_NO_CODEC_AVAILABLE)
    fail(ErrorCode::kUnsupportedMedia, "this AVIF has a feature that is not read");
  fail_damaged(kFormat, avifResultToString(result));
}

// Parsed, nothing decoded yet.
Decoder open_decoder(std::span<const std::byte> file, std::int64_t most_px) {
  Decoder decoder(avifDecoderCreate(), avifDecoderDestroy);
  if (!decoder) fail(ErrorCode::kTooLarge, "there is no memory to decode the AVIF");
  decoder->imageSizeLimit = std::uint32_t(std::min<std::int64_t>(most_px, AVIF_DEFAULT_IMAGE_SIZE_LIMIT));
  decoder->imageDimensionLimit = 0;
  decoder->imageCountLimit = 1;
  decoder->maxThreads = 1;  // a sandboxed process may start none
  decoder->ignoreExif = decoder->ignoreXMP = AVIF_TRUE;
  if (avifCodecName(AVIF_CODEC_CHOICE_DAV1D, AVIF_CODEC_FLAG_CAN_DECODE) != nullptr)
    decoder->codecChoice = AVIF_CODEC_CHOICE_DAV1D;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  check(avifDecoderSetIOMemory(decoder.get(), bytes, file.size()));
  check(avifDecoderParse(decoder.get()));
  return decoder;
}

}  // namespace

Image decode_avif(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits) {
  const Decoder claim = open_decoder(file, AVIF_DEFAULT_IMAGE_SIZE_LIMIT);
  const std::int64_t width = claim->image->width, height = claim->image->height;
  check_extent(kFormat, width, height, limits);
  // The AV1 stream inside may claim another size: now it is held to that of the container.
  const Decoder decoder = open_decoder(file, width * height);
  check(avifDecoderNextImage(decoder.get()));
  const avifImage& picture = *decoder->image;
  check_extent(kFormat, picture.width, picture.height, limits);

  const bool alpha = picture.alphaPlane != nullptr, deep = picture.depth > 8;
  Image image = make_image({int(picture.width), int(picture.height)}, alpha ? 4 : 3,
                           deep ? SampleType::kUint16 : SampleType::kUint8, color_space);
  avifRGBImage rgb;
  avifRGBImageSetDefaults(&rgb, &picture);
  rgb.depth = deep ? 16 : 8;
  rgb.format = alpha ? AVIF_RGB_FORMAT_RGBA : AVIF_RGB_FORMAT_RGB;
  rgb.chromaUpsampling = AVIF_CHROMA_UPSAMPLING_BEST_QUALITY;
  rgb.pixels = reinterpret_cast<std::uint8_t*>(image.pixels.data());
  rgb.rowBytes = std::uint32_t(image.row_bytes());
  check(avifImageYUVToRGB(&picture, &rgb));
  return image;
}

}  // namespace furnace
