// Every truncation and many bit flips of small files: each gives an error or a picture, never a crash. Run it under the
// sanitizers for its full worth.
#include "tests/image/sample_files.hpp"
#include "renderer/image/codecs.hpp"
#include "renderer/image/encode.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace furnace {
namespace {

// Small, so that a damaged extent cannot make the test slow.
constexpr DecodeLimits kLimits = {.max_side_px = 2048, .max_area_px = 1 << 20};

using Decode = std::function<void(const std::string&)>;

void decode_as_texture(const std::string& file) {
  decode_texture(Blob(file), ColorSpace::kSrgb, kLimits);
}
void decode_as_rgbe(const std::string& file) {
  decode_rgbe(std::as_bytes(std::span(file)), kLimits, Shape::kAny);
}
void decode_as_exr(const std::string& file) {
  decode_exr(std::as_bytes(std::span(file)), kLimits, Shape::kAny);
}

void expect_verdict(const Decode& decode, const std::string& file) {
  try {
    decode(file);
  } catch (const Error& error) {
    ASSERT_FALSE(error.message.empty());
    ASSERT_TRUE(error.code == ErrorCode::kUnprocessable || error.code == ErrorCode::kTooLarge ||
                error.code == ErrorCode::kUnsupportedMedia)
        << error.message;
  }
}

void expect_no_crash(const Decode& decode, const std::string& file, int flips, std::uint32_t seed) {
  ASSERT_NO_THROW(decode(file)) << "the file was damaged before";
  for (std::size_t size = 0; size < file.size(); ++size) expect_verdict(decode, file.substr(0, size));
  std::mt19937 random(seed);
  for (int i = 0; i < flips; ++i) {
    std::string damaged = file;
    for (std::uint32_t n = 1 + sample::next(random, 3); n > 0; --n) {
      const auto place = sample::next(random, static_cast<std::uint32_t>(file.size()));
      // A bit, a byte or a value that sizes and counts fear.
      static constexpr char kNasty[] = {'\0', '\1', '\x7f', '\x80', '\xff'};
      switch (sample::next(random, 3)) {
        case 0:
          damaged[place] = static_cast<char>(damaged[place] ^ 1 << sample::next(random, 8));
          break;
        case 1:
          damaged[place] = static_cast<char>(random());
          break;
        default:
          damaged[place] = kNasty[sample::next(random, 5)];
          break;
      }
    }
    expect_verdict(decode, damaged);
  }
}

TEST(Damage, Png) {
  const auto decode = [](const std::string& file) { decode_as_texture(sample::with_right_checksums(file)); };
  for (bool interlaced : {false, true}) {
    expect_no_crash(decode, sample::png(7, 5, sample::noise(7 * 5 * 3, 1), {.interlaced = interlaced}), 1500,
                    1);
    expect_no_crash(
        decode,
        sample::png(
            9, 5, sample::noise(3 * 5, 1),
            {.color_type = 0, .depth = 2, .interlaced = interlaced, .transparency = std::string(2, '\0')}),
        1500, 2);
    expect_no_crash(decode,
                    sample::png(7, 5, sample::noise(7 * 5, 1),
                                {.color_type = 3,
                                 .interlaced = interlaced,
                                 .palette = std::string(768, 'x'),
                                 .transparency = "abc"}),
                    1500, 3);
  }
  expect_no_crash(decode, sample::png(7, 5, sample::noise(7 * 5 * 8, 1), {.color_type = 6, .depth = 16}),
                  1500, 4);
}

TEST(Damage, Jpeg) {
  using sample::JpegKind;
  for (JpegKind kind : {JpegKind::kRgb, JpegKind::kProgressive}) {
    expect_no_crash(decode_as_texture, sample::flat_jpeg(20, 20, {200, 100, 30}, kind), 1500, 5);
  }
  expect_no_crash(decode_as_texture, sample::flat_jpeg(20, 20, {1, 2, 3, 4}, JpegKind::kAdobeCmyk), 1500, 6);
}

TEST(Damage, Webp) {
  expect_no_crash(decode_as_texture, sample::lossless_webp(9, 9, 4, sample::noise(9 * 9 * 4, 7)), 1500, 7);
}

TEST(Damage, Avif) {
  for (const int channels : {3, 4})
    expect_no_crash(decode_as_texture,
                    sample::lossless_avif(9, 9, channels, 8, sample::noise(9u * 9u * unsigned(channels), 7)),
                    300, 7);
}

TEST(Damage, Rgbe) {
  std::string planar = sample::rgbe_header(16, 3);
  for (int y = 0; y < 3; ++y) {
    planar += std::string({2, 2, 0, 16});
    for (int component = 0; component < 4; ++component)
      planar += std::string({'\x8a', 100, 6, 1, 2, 3, 4, 5, 6});
  }
  expect_no_crash(decode_as_rgbe, planar, 4000, 8);
  std::string old = sample::rgbe_header(16, 2);
  for (int y = 0; y < 2; ++y) old += std::string({9, 8, 7, 120, 1, 1, 1, 10, 5, 4, 3, 120, 1, 1, 1, 4});
  expect_no_crash(decode_as_rgbe, old, 4000, 9);
}

TEST(Damage, Exr) {
  for (Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION,
        Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::DWAA_COMPRESSION}) {
    for (bool is_tiled : {false, true}) {
      SCOPED_TRACE(testing::Message() << "compression " << compression << (is_tiled ? ", tiled" : ""));
      expect_no_crash(decode_as_exr, sample::small_exr(compression, is_tiled), 400,
                      10 + static_cast<std::uint32_t>(compression));
    }
  }
}

}  // namespace
}  // namespace furnace
