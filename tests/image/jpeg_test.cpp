#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace furnace {
namespace {

using sample::JpegKind;

const DecodeLimits kLimits;

// At quality 100 a flat colour survives but for the rounding of the colour transform: 2 steps.
constexpr int kTolerance = 2;

void expect_flat(const std::string& file, Extent extent, const std::vector<int>& color) {
  const Image image = decode_texture(Blob(file), ColorSpace::kSrgb, kLimits);
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

TEST(JpegDecode, ChecksLimitsFirst) {
  const Blob file(sample::flat_jpeg(20, 10, {90}, JpegKind::kGrey));
  const auto code = [&](const DecodeLimits& limits) {
    return sample::error_of([&] { decode_texture(file, ColorSpace::kSrgb, limits); }).code;
  };
  EXPECT_EQ(code({.max_side_px = 19}), ErrorCode::kTooLarge);
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

}  // namespace
}  // namespace furnace
