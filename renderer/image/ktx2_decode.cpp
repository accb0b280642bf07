// KTX 2.0: levels out of their supercompression and block compression, as RGBA.
#include "renderer/image/codecs.hpp"
#include "renderer/image/etc1s_decode.hpp"
#include "renderer/image/ktx2_container.hpp"
#include "renderer/image/uastc_decode.hpp"
#include "renderer/base/error.hpp"

#include <fmt/format.h>
#include <libdeflate.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace furnace {

namespace {

constexpr std::string_view kFormat = "KTX2";

// Formats of whole numbers, by VkFormat.
struct PlainFormat {
  std::uint32_t vk_format;
  int channels;
  SampleType type;
  bool blue_first = false;
};
constexpr std::array<PlainFormat, 16> kPlainFormats{{{9, 1, SampleType::kUint8},
                                                     {15, 1, SampleType::kUint8},
                                                     {16, 2, SampleType::kUint8},
                                                     {22, 2, SampleType::kUint8},
                                                     {23, 3, SampleType::kUint8},
                                                     {29, 3, SampleType::kUint8},
                                                     {30, 3, SampleType::kUint8, true},
                                                     {36, 3, SampleType::kUint8, true},
                                                     {37, 4, SampleType::kUint8},
                                                     {43, 4, SampleType::kUint8},
                                                     {44, 4, SampleType::kUint8, true},
                                                     {50, 4, SampleType::kUint8, true},
                                                     {70, 1, SampleType::kUint16},
                                                     {77, 2, SampleType::kUint16},
                                                     {84, 3, SampleType::kUint16},
                                                     {91, 4, SampleType::kUint16}}};

enum class Coding { kPlain, kEtc1s, kUastc };

// How the texels are coded. Errors: kUnsupportedMedia.
Coding coding_of(const Ktx2& file, const PlainFormat*& plain) {
  const bool lz = file.scheme == Ktx2Scheme::kBasisLz;
  if (file.vk_format == 0 && file.model == kDfModelEtc1s && lz) return Coding::kEtc1s;
  if (file.vk_format == 0 && file.model == kDfModelUastc && !lz) return Coding::kUastc;
  plain = std::ranges::find(kPlainFormats, file.vk_format, &PlainFormat::vk_format);
  if (plain != kPlainFormats.end() && !lz) return Coding::kPlain;
  fail(ErrorCode::kUnsupportedMedia,
       fmt::format(
           "a KTX2 texture is ETC1S, UASTC or of 8 or 16 bits a channel; this one is of VkFormat {} and "
           "color model {}",
           file.vk_format, file.model));
}

// Exactly `size` bytes, which the format and extent ask for: what a file claims of itself is not needed.
std::vector<std::byte> inflated(const Ktx2& file, std::span<const std::byte> stored, std::size_t size) {
  if (file.scheme == Ktx2Scheme::kNone) {
    if (stored.size() < size) fail_damaged(kFormat, "a level is too short");
    return {stored.begin(), stored.begin() + std::ptrdiff_t(size)};
  }
  std::vector<std::byte> out(size);
  if (file.scheme == Ktx2Scheme::kZstandard) {
    if (ZSTD_decompress(out.data(), size, stored.data(), stored.size()) != size)
      fail_damaged(kFormat, "its Zstandard data");
    return out;
  }
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!decompressor || libdeflate_zlib_decompress(decompressor.get(), stored.data(), stored.size(),
                                                  out.data(), size, nullptr) != LIBDEFLATE_SUCCESS)
    fail_damaged(kFormat, "its ZLIB data");
  return out;
}

// Absent colours are 0, absent alpha is opaque, as Vulkan has it.
template <class T>
void fill_plain(const PlainFormat& format, const std::vector<std::byte>& bytes, Image& image) {
  const auto channels = std::size_t(format.channels);
  T* to = image.samples<T>().data();
  for (std::size_t at = 0; at < bytes.size(); at += channels * sizeof(T), to += 4) {
    std::array<T, 4> texel{0, 0, 0, T(~T(0))};
    std::memcpy(texel.data(), &bytes[at], channels * sizeof(T));
    if (format.blue_first) std::swap(texel[0], texel[2]);
    std::ranges::copy(texel, to);
  }
}

Image decode_plain(const Ktx2& file, const Ktx2Level& level, const PlainFormat& format, ColorSpace space) {
  Image image = make_image(level.extent, 4, format.type, space);
  const std::size_t size =
      std::size_t(level.extent.area()) * std::size_t(format.channels) * sample_bytes(format.type);
  const std::vector<std::byte> bytes = inflated(file, level.bytes, size);
  if (format.type == SampleType::kUint8) {
    fill_plain<std::uint8_t>(format, bytes, image);
  } else {
    fill_plain<std::uint16_t>(format, bytes, image);
  }
  return image;
}

// What the four numbers of a UASTC texel mean.
std::array<std::uint8_t, 4> uastc_color(const std::array<std::uint8_t, 4>& texel, std::uint8_t channel) {
  constexpr std::uint8_t kRgb = 0, kRrr = 4, kRrrg = 5, kRg = 6;
  switch (channel) {
    case kRgb:
      return {texel[0], texel[1], texel[2], 255};
    case kRrr:
      return {texel[0], 0, 0, 255};
    case kRrrg:
      return {texel[0], texel[3], 0, 255};
    case kRg:
      return {texel[0], texel[1], 0, 255};
    default:
      return texel;
  }
}

Image decode_uastc(const Ktx2& file, const Ktx2Level& level, ColorSpace space) {
  const Extent extent = level.extent;
  const int blocks_x = (extent.width + 3) / 4, blocks_y = (extent.height + 3) / 4;
  const std::vector<std::byte> bytes =
      inflated(file, level.bytes, std::size_t(blocks_x) * std::size_t(blocks_y) * kUastcBlockBytes);
  Image image = make_image(extent, 4, SampleType::kUint8, space);
  const auto samples = image.samples<std::uint8_t>();
  std::span<const std::byte> rest(bytes);
  UastcTexels texels;
  for (int y = 0; y < extent.height; y += 4) {
    for (int x = 0; x < extent.width; x += 4) {
      if (!decode_uastc_block(rest.first(kUastcBlockBytes), texels))
        fail_damaged(kFormat, "a block of its texels");
      rest = rest.subspan(kUastcBlockBytes);
      for (int row = 0; row < std::min(4, extent.height - y); ++row) {
        for (int column = 0; column < std::min(4, extent.width - x); ++column) {
          const auto color = uastc_color(texels[std::size_t(row * 4 + column)], file.channels[0]);
          const auto at = (std::size_t(y + row) * std::size_t(extent.width) + std::size_t(x + column)) * 4;
          std::ranges::copy(color, samples.begin() + std::ptrdiff_t(at));
        }
      }
    }
  }
  return image;
}

// Channels of ETC1S slices: the first is RGB or red alone, the second alpha or green.
Image decode_etc1s(const Ktx2& file, const Etc1sCodebooks& books, std::size_t index, ColorSpace space) {
  constexpr std::uint8_t kRrr = 3;
  const Ktx2Level& level = file.levels[index];
  const auto slice = [&](const Etc1sCodebooks::Slice& place) {
    if (place.offset > level.bytes.size() || place.size > level.bytes.size() - place.offset)
      fail_damaged(kFormat, "the place of a slice");
    return books.decode(level.bytes.subspan(place.offset, place.size), level.extent);
  };
  const Etc1sCodebooks::Picture& picture = books.pictures()[index];
  const std::vector<std::uint8_t> color = slice(picture.color);
  const std::vector<std::uint8_t> second =
      picture.alpha.size > 0 ? slice(picture.alpha) : std::vector<std::uint8_t>();
  const bool data = file.channels[0] == kRrr;
  Image image = make_image(level.extent, 4, SampleType::kUint8, space);
  std::uint8_t* to = image.samples<std::uint8_t>().data();
  for (std::size_t i = 0; i < color.size(); i += 3, to += 4) {
    const std::uint8_t other = second.empty() ? 255 : second[i + 1];
    const std::array<std::uint8_t, 4> texel =
        data ? std::array<std::uint8_t, 4>{color[i], second.empty() ? std::uint8_t(0) : other, 0, 255}
             : std::array<std::uint8_t, 4>{color[i], color[i + 1], color[i + 2], other};
    std::ranges::copy(texel, to);
  }
  return image;
}

template <class T>
void arrange(const Ktx2& file, Image& image) {
  const auto width = std::size_t(image.extent.width), height = std::size_t(image.extent.height);
  using Texel = std::array<T, 4>;
  auto* texels = reinterpret_cast<Texel*>(image.pixels.data());
  if (std::string_view(file.swizzle.data(), 4) != "rgba") {
    for (Texel& texel : std::span(texels, width * height)) {
      const Texel from = texel;
      for (std::size_t c = 0; c < 4; ++c) {
        const std::size_t which = std::string_view("rgba01").find(file.swizzle[c]);
        texel[c] = which < 4 ? from[which] : which == 4 ? T(0) : T(~T(0));
      }
    }
  }
  if (file.right_to_left) {
    for (std::size_t y = 0; y < height; ++y) std::reverse(texels + y * width, texels + (y + 1) * width);
  }
  for (std::size_t y = 0; file.bottom_up && y < height / 2; ++y)
    std::swap_ranges(texels + y * width, texels + (y + 1) * width, texels + (height - 1 - y) * width);
}

// The first level that is within the limits, else the last.
std::size_t first_level(const Ktx2& file, int max_side_px) {
  for (std::size_t i = 0; i < file.levels.size(); ++i) {
    if (std::max(file.levels[i].extent.width, file.levels[i].extent.height) <= max_side_px) return i;
  }
  return file.levels.size() - 1;
}

void remark(const Ktx2& file, ColorSpace space, std::vector<TextureRemark>& remarks) {
  const bool color = space == ColorSpace::kSrgb;
  if (file.transfer == (color ? kDfTransferLinear : kDfTransferSrgb)) {
    remarks.push_back(
        {"texture-color-space", color ? "says that it is linear, but its use says sRGB, which was taken"
                                      : "says that it is sRGB, but its use says data, which was taken"});
  }
  if (file.premultiplied)
    remarks.push_back(
        {"texture-premultiplied", "says that its alpha is multiplied in; it was taken as straight"});
}

}  // namespace

DecodedTexture decode_ktx2(std::span<const std::byte> bytes, ColorSpace space, const DecodeLimits& limits) {
  const Ktx2 file = open_ktx2(bytes, limits);
  const PlainFormat* plain = nullptr;
  const Coding coding = coding_of(file, plain);
  std::optional<Etc1sCodebooks> books;
  if (coding == Coding::kEtc1s) books.emplace(file.global_data, file.levels.size());
  DecodedTexture texture;
  remark(file, space, texture.remarks);
  for (std::size_t i = first_level(file, limits.max_side_px); i < file.levels.size(); ++i) {
    const Ktx2Level& level = file.levels[i];
    Image image = coding == Coding::kEtc1s   ? decode_etc1s(file, *books, i, space)
                  : coding == Coding::kUastc ? decode_uastc(file, level, space)
                                             : decode_plain(file, level, *plain, space);
    if (image.type == SampleType::kUint8) {
      arrange<std::uint8_t>(file, image);
    } else {
      arrange<std::uint16_t>(file, image);
    }
    texture.levels.push_back(std::move(image));
  }
  return texture;
}

void check_ktx2_readable(std::span<const std::byte> bytes) {
  const PlainFormat* plain = nullptr;
  coding_of(open_ktx2(bytes, {}), plain);
}

}  // namespace furnace
