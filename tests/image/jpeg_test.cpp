#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace furnace {
namespace {

using sample::JpegKind;

const DecodeLimits kLimits;

// At quality 100 a flat colour survives but for the rounding of the colour transform: 2 steps.
constexpr int kTolerance = 2;

void expect_flat(const std::string& file, Extent extent, const std::vector<int>& color) {
  const Image image = sample::picture(file, ColorSpace::kSrgb, kLimits);
  ASSERT_EQ(image.extent, extent);
  ASSERT_EQ(image.channels, static_cast<int>(color.size()));
  ASSERT_EQ(image.type, SampleType::kUint8);
  const auto samples = image.samples<std::uint8_t>();
  for (std::size_t i = 0; i < samples.size(); ++i)
    ASSERT_NEAR(samples[i], color[i % color.size()], kTolerance) << i;
}

TEST(JpegDecode, ReadsGreyAndColour) {
  expect_flat(sample::flat_jpeg(17, 9, {90}, JpegKind::kGrey), {17, 9}, {90});
  expect_flat(sample::flat_jpeg(17, 9, {200, 100, 30}, JpegKind::kRgb), {17, 9}, {200, 100, 30});
  expect_flat(sample::flat_jpeg(17, 9, {20, 100, 230}, JpegKind::kProgressive), {17, 9}, {20, 100, 230});
}

// RGB = (1 - CMY) (1 - K); Adobe's files store the complement of each.
TEST(JpegDecode, ConvertsCmyk) {
  const auto expected = [](int c, int k) { return ((255 - c) * (255 - k) + 127) / 255; };
  const std::vector<int> rgb = {expected(10, 40), expected(90, 40), expected(200, 40)};
  expect_flat(sample::flat_jpeg(8, 8, {10, 90, 200, 40}, JpegKind::kCmyk), {8, 8}, rgb);
  expect_flat(sample::flat_jpeg(8, 8, {245, 165, 55, 215}, JpegKind::kAdobeCmyk), {8, 8}, rgb);
}

// glTF 2.0, section 3.8.4: an orientation that the file tells (here a quarter turn) is not applied.
TEST(JpegDecode, IgnoresOrientation) {
  const std::string file = sample::flat_jpeg(17, 9, {200, 100, 30}, JpegKind::kRgb);
  const std::string exif(
      "\xff\xe1\x00\x22"
      "Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0",
      36);
  expect_flat(file.substr(0, 2) + exif + file.substr(2), {17, 9}, {200, 100, 30});
}

TEST(JpegDecode, ChecksLimitsFirst) {
  const Blob file(sample::flat_jpeg(20, 10, {90}, JpegKind::kGrey));
  const auto code = [&](const DecodeLimits& limits) {
    return sample::error_of([&] { decode_texture(file, ColorSpace::kSrgb, limits); }).code;
  };
  EXPECT_EQ(code({.max_area_px = 199}), ErrorCode::kTooLarge);
}

TEST(JpegDecode, RefusesAPictureThatEndsEarly) {
  const std::string file = sample::flat_jpeg(200, 200, {200, 100, 30}, JpegKind::kRgb);
  const Error error = sample::error_of(
      [&] { decode_texture(Blob(file.substr(0, file.size() / 2)), ColorSpace::kSrgb, kLimits); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.message, testing::HasSubstr("JPEG"));
}

// The scans of a progressive file cost a pass over the picture each: a small file must not ask for thousands.
TEST(JpegDecode, RefusesEndlessScans) {
  const std::string file = sample::flat_jpeg(64, 64, {200, 100, 30}, JpegKind::kProgressive);
  const auto scan_at = [&](std::size_t from) { return file.find("\xff\xda", from); };
  const std::size_t first = scan_at(0), second = scan_at(first + 2);
  ASSERT_NE(second, std::string::npos);
  std::string bomb = file.substr(0, first);
  for (int i = 0; i < 1000; ++i) bomb += file.substr(first, second - first);
  bomb += file.substr(second);
  const Error error = sample::error_of([&] { decode_texture(Blob(bomb), ColorSpace::kSrgb, kLimits); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.message, testing::HasSubstr("scans"));
}

Image flat(Extent extent, const std::vector<std::uint8_t>& color) {
  Image image = make_image(extent, static_cast<int>(color.size()), SampleType::kUint8, ColorSpace::kSrgb);
  const auto samples = image.samples<std::uint8_t>();
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = color[i % color.size()];
  return image;
}

TEST(JpegEncode, IsReadByLibjpeg) {
  expect_flat(encode_jpeg(flat({17, 9}, {200, 100, 30}), 100, {}), {17, 9}, {200, 100, 30});
  expect_flat(encode_jpeg(flat({1, 1}, {90}), 100, {}), {1, 1}, {90});
}

// Columns of one pixel, red and blue of one luma: halved chroma would mix them.
TEST(JpegEncode, KeepsChromaWhole) {
  Image stripes = flat({32, 16}, {200, 0, 0});
  for (std::size_t i = 0; i < stripes.pixels.size(); i += 6) {
    stripes.samples<std::uint8_t>()[i] = 0;
    stripes.samples<std::uint8_t>()[i + 2] = 200;
  }
  const Image back = sample::picture(encode_jpeg(stripes, 95, {}), ColorSpace::kSrgb, kLimits);
  for (std::size_t i = 0; i < back.pixels.size(); ++i) {
    // Quality 95 quantises the highest frequency in steps of about ten.
    ASSERT_NEAR(back.samples<std::uint8_t>()[i], stripes.samples<std::uint8_t>()[i], 25) << i;
  }
}

TEST(JpegEncode, QualityIsSizeAndBytesAreTheSame) {
  Image image = flat({64, 64}, {0, 0, 0});
  const auto noise = sample::noise(image.pixels.size(), 4);
  std::ranges::copy(noise, image.samples<std::uint8_t>().begin());
  EXPECT_LT(encode_jpeg(image, 30, {}).size(), encode_jpeg(image, 90, {}).size());
  EXPECT_EQ(encode_jpeg(image, 90, {}), encode_jpeg(image, 90, {}));
}

// A comment is the marker FF FE, two bytes of length that count themselves, and the text.
TEST(JpegEncode, MetadataIsComments) {
  const std::string file =
      encode_jpeg(flat({8, 8}, {1, 2, 3}), 90, {{"Software", "F 1"}, {"furnace:request", "abc"}});
  EXPECT_THAT(file, testing::HasSubstr(std::string("\xff\xfe\x00\x0fSoftware: F 1", 17)));
  EXPECT_THAT(file, testing::HasSubstr(std::string("\xff\xfe\x00\x16"
                                                   "furnace:request: abc",
                                                   24)));
}

TEST(JpegEncodeDeathTest, RefusesWhatHasAlpha) {
  EXPECT_DEATH(encode_jpeg(make_image({1, 1}, 4, SampleType::kUint8, ColorSpace::kSrgb), 90, {}), "channels");
}

}  // namespace
}  // namespace furnace
