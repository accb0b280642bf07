#include "renderer/image/codecs.hpp"
#include "renderer/base/error.hpp"

#include <webp/decode.h>

namespace furnace {

Image decode_webp(std::span<const std::byte> file, ColorSpace color_space, const DecodeLimits& limits) {
  constexpr std::string_view kFormat = "WebP";
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes, file.size(), &features) != VP8_STATUS_OK) fail_damaged(kFormat, "its header");
  if (features.has_animation) fail(ErrorCode::kUnsupportedMedia, "an animated WebP is not a texture");
  check_extent(kFormat, features.width, features.height, limits);

  const int channels = features.has_alpha ? 4 : 3;
  Image image = make_image({features.width, features.height}, channels, SampleType::kUint8, color_space);
  const auto decode = features.has_alpha ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
  auto* out = image.samples<std::uint8_t>().data();
  if (!decode(bytes, file.size(), out, image.byte_size(), static_cast<int>(image.row_bytes()))) {
    fail_damaged(kFormat, "its pixels");
  }
  return image;
}

}  // namespace furnace
