// Headers say what decoding then finds, for files made by other libraries; damage is never more than unknown.
#include "renderer/image/image_header.hpp"

#include <gtest/gtest.h>

#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"
#include "tests/image/sample_files.hpp"

namespace furnace {
namespace {

std::optional<ImageHeader> header_of(std::string_view file) {
  return read_image_header(std::as_bytes(std::span(file)));
}

std::vector<std::string> sample_textures() {
  std::vector<std::string> files;
  for (const auto& [type, depth, channels] :
       {std::tuple{0, 8, 1}, {0, 16, 1}, {2, 8, 3}, {2, 16, 3}, {4, 8, 2}, {6, 8, 4}, {6, 16, 4}}) {
    const auto bytes = static_cast<std::size_t>(13 * 7 * channels * depth / 8);
    files.push_back(sample::png(13, 7, sample::noise(bytes, 1), {.color_type = type, .depth = depth}));
  }
  const std::vector<std::uint8_t> palette_rows(13 * 7, 1);
  const std::string palette = "abcdef";
  files.push_back(sample::png(13, 7, palette_rows, {.color_type = 3, .palette = palette}));
  files.push_back(
      sample::png(13, 7, palette_rows, {.color_type = 3, .palette = palette, .transparency = "\x10"}));
  // The same chunk behind the pixels, where it counts for nothing.
  std::string late = files.back();
  const std::size_t from = late.find("tRNS") - 4;
  constexpr std::size_t kChunk = 13;
  const std::string chunk = late.substr(from, kChunk);
  late.erase(from, kChunk).insert(late.find("IEND") - 4, chunk);
  files.push_back(late);
  files.push_back(sample::flat_jpeg(31, 9, {100}, sample::JpegKind::kGrey));
  files.push_back(sample::flat_jpeg(31, 9, {100, 20, 30}, sample::JpegKind::kRgb));
  files.push_back(sample::flat_jpeg(31, 9, {100, 20, 30}, sample::JpegKind::kProgressive));
  files.push_back(sample::flat_jpeg(31, 9, {100, 20, 30, 40}, sample::JpegKind::kAdobeCmyk));
  for (const int channels : {3, 4}) {
    const auto samples = sample::noise(31u * 17u * static_cast<std::size_t>(channels), 3);
    files.push_back(sample::lossless_webp(31, 17, channels, samples));
    Image image = make_image({33, 21}, channels, SampleType::kUint8, ColorSpace::kSrgb);
    files.push_back(encode_webp(image, {.lossless = false, .quality = 80}, {}));
  }
  return files;
}

TEST(ImageHeader, SaysWhatDecodingFinds) {
  for (const std::string& file : sample_textures()) {
    const auto header = header_of(file);
    ASSERT_TRUE(header);
    const Image image = decode_texture(Blob(file).bytes(), ColorSpace::kSrgb, {}).levels.front();
    EXPECT_EQ(header->format, image_format_name(sniff_image_format(Blob(file))));
    EXPECT_EQ(int(header->width), image.extent.width) << header->format;
    EXPECT_EQ(int(header->height), image.extent.height) << header->format;
    EXPECT_EQ(header->channels, image.channels) << header->format;
    EXPECT_EQ(header->bits, int(8 * sample_bytes(image.type))) << header->format;
  }
}

TEST(ImageHeader, Ktx2) {
  std::string ktx2("\xabKTX 20\xbb\r\n\x1a\n", 12);
  for (const int word : {0, 1, 640, 480, 0, 0, 1, 1, 1})
    for (int shift = 0; shift < 32; shift += 8) ktx2 += static_cast<char>(word >> shift);
  const auto header = header_of(ktx2);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->format, "KTX2");
  EXPECT_EQ(header->width, 640u);
  EXPECT_EQ(header->height, 480u);
}

// The decoder takes what names the brand anywhere in its list, as files of other brands that are AVIF, too, do.
TEST(ImageHeader, AvifByAnyOfItsBrands) {
  for (const std::string& brands :
       {std::string("avif\0\0\0\0miaf", 12), std::string("mif1\0\0\0\0avif", 12)}) {
    const auto header = header_of(std::string("\0\0\0\x14", 4) + "ftyp" + brands);
    ASSERT_TRUE(header);
    EXPECT_EQ(header->format, "AVIF");
  }
  EXPECT_FALSE(header_of(std::string("\0\0\0\x14", 4) + "ftyp" + std::string("mif1\0\0\0\0heic", 12)));
}

TEST(ImageHeader, DamageAndOtherFiles) {
  EXPECT_FALSE(header_of(""));
  EXPECT_FALSE(header_of("#?RADIANCE\n"));
  EXPECT_FALSE(header_of(std::string(100, '\0')));
  std::mt19937 random(11);
  for (const std::string& file : sample_textures()) {
    for (std::size_t size = 0; size < std::min<std::size_t>(file.size(), 200); ++size) {
      const auto cut = header_of(file.substr(0, size));
      EXPECT_TRUE(size > 20 || !cut || !cut->is_complete());
    }
    for (int round = 0; round < 300; ++round) {
      std::string damaged = file;
      for (int i = 0; i < 3; ++i)
        damaged[random() % std::min<std::size_t>(damaged.size(), 120)] = static_cast<char>(random());
      header_of(damaged);
    }
  }
}

}  // namespace
}  // namespace furnace
