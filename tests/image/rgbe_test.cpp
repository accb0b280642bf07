#include "tests/image/sample_files.hpp"
#include "renderer/image/codecs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace furnace {
namespace {

using Pixel = std::array<std::uint8_t, 4>;
using Row = std::vector<Pixel>;

const DecodeLimits kLimits;

Image decode(const std::string& file) {
  return decode_rgbe(std::as_bytes(std::span(file)), kLimits, Shape::kAny);
}

// Ward 1991: v = mantissa * 2^(e - 128 - 8), and exponent 0 is black.
float meaning(std::uint8_t mantissa, std::uint8_t exponent) {
  return exponent == 0 ? 0.0f : static_cast<float>(std::ldexp(mantissa, exponent - 136));
}

void expect_rows(const std::string& file, const std::vector<Row>& rows) {
  const Image image = decode(file);
  ASSERT_EQ(image.extent, (Extent{static_cast<int>(rows[0].size()), static_cast<int>(rows.size())}));
  ASSERT_EQ(image.channels, 3);
  ASSERT_EQ(image.type, SampleType::kFloat32);
  std::size_t i = 0;
  for (const Row& row : rows) {
    for (const Pixel& pixel : row) {
      for (int channel = 0; channel < 3; ++channel, ++i) {
        ASSERT_EQ(image.samples<float>()[i], meaning(pixel[static_cast<std::size_t>(channel)], pixel[3]))
            << i;
      }
    }
  }
}

std::string flat(const Row& row) {
  std::string bytes;
  for (const Pixel& pixel : row) bytes.append(pixel.begin(), pixel.end());
  return bytes;
}

// The later scheme, with runs where a component repeats at least three times.
std::string planar(const Row& row) {
  const std::size_t width = row.size();
  std::string bytes = {2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)};
  for (std::size_t component = 0; component < 4; ++component) {
    for (std::size_t x = 0; x < width;) {
      std::size_t run = 1;
      while (x + run < width && run < 127 && row[x + run][component] == row[x][component]) ++run;
      bytes += static_cast<char>(run >= 3 ? 128 + run : 1);
      bytes += static_cast<char>(row[x][component]);
      x += run >= 3 ? run : 1;
    }
  }
  return bytes;
}

Row random_row(std::size_t width, std::uint32_t seed) {
  std::mt19937 random(seed);
  Row row(width);
  for (std::size_t x = 0; x < width; ++x) {
    if (x > 0 && sample::next(random, 3) > 0) {
      row[x] = row[x - 1];
      continue;
    }
    // Neither (2, 2, ...) nor (1, 1, 1, ...): those begin a run.
    for (std::uint8_t& byte : row[x]) byte = static_cast<std::uint8_t>(3 + sample::next(random, 250));
  }
  return row;
}

TEST(RgbeDecode, ReadsFlatRows) {
  const std::vector<Row> rows = {{{128, 64, 32, 129}, {255, 0, 1, 0}, {10, 20, 30, 255}}, random_row(3, 1)};
  expect_rows(sample::rgbe_header(3, 2) + flat(rows[0]) + flat(rows[1]), rows);
}

TEST(RgbeDecode, ReadsTheLaterRunLengths) {
  for (std::size_t width : {8u, 9u, 127u, 128u, 300u, 700u}) {
    const std::vector<Row> rows = {random_row(width, 1), Row(width, {5, 6, 7, 140}), random_row(width, 2)};
    std::string file = sample::rgbe_header(static_cast<int>(width), 3);
    for (const Row& row : rows) file += planar(row);
    expect_rows(file, rows);
  }
}

TEST(RgbeDecode, ReadsTheOldRunLengths) {
  // 5, then 3 more of it, one of 9, then 0x0102 more of that: consecutive counts are digits in base 256, low first.
  Row row = {{5, 5, 5, 130}, {5, 5, 5, 130}, {5, 5, 5, 130}, {5, 5, 5, 130}};
  row.insert(row.end(), 1 + 0x0102, {9, 8, 7, 131});
  const std::string bytes = {5, 5, 5, '\x82', 1, 1, 1, 3, 9, 8, 7, '\x83', 1, 1, 1, 2, 1, 1, 1, 1};
  const auto width = static_cast<int>(row.size());
  expect_rows(sample::rgbe_header(width, 2) + bytes + bytes, {row, row});
}

TEST(RgbeDecode, MixesSchemesByRow) {
  const std::vector<Row> rows = {random_row(20, 1), random_row(20, 2), random_row(20, 3)};
  expect_rows(sample::rgbe_header(20, 3) + planar(rows[0]) + flat(rows[1]) + planar(rows[2]), rows);
}

TEST(RgbeDecode, TurnsRowsAndColumns) {
  const Row upper = {{10, 20, 30, 130}, {40, 50, 60, 130}}, lower = {{70, 80, 90, 130}, {11, 12, 13, 130}};
  const Row upper_mirrored = {upper[1], upper[0]}, lower_mirrored = {lower[1], lower[0]};
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  expect_rows(head + "-Y 2 +X 2\n" + flat(upper) + flat(lower), {upper, lower});
  expect_rows(head + "+Y 2 +X 2\n" + flat(upper) + flat(lower), {lower, upper});
  expect_rows(head + "-Y 2 -X 2\n" + flat(upper) + flat(lower), {upper_mirrored, lower_mirrored});
  expect_rows(head + "+Y 2 -X 2\n" + flat(upper) + flat(lower), {lower_mirrored, upper_mirrored});
}

TEST(RgbeDecode, RefusesWhatItCannotRead) {
  const auto error = [](const std::string& file) { return sample::error_of([&] { decode(file); }); };
  EXPECT_EQ(error("#?RADIANCE\n\n+X 2 -Y 2\n" + std::string(16, '\x20')).code, ErrorCode::kUnsupportedMedia);
  EXPECT_EQ(error("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n    ").code,
            ErrorCode::kUnsupportedMedia);
  for (const std::string resolution : {"", "-Y 2", "-Y 2 +X", "-Y x +X 2", "-Y 2 +X 2 z", "-Y 0 +X 2",
                                       "-Y -2 +X 2", "-Y 99999999999999999999 +X 2", "Y 2 X 2"}) {
    EXPECT_EQ(error("#?RADIANCE\n\n" + resolution + "\n" + std::string(64, '\x20')).code,
              ErrorCode::kUnprocessable)
        << resolution;
  }
  EXPECT_EQ(error("#?RADIANCE\nFORMAT").code, ErrorCode::kUnprocessable);
  EXPECT_EQ(error(sample::rgbe_header(40000, 2)).code, ErrorCode::kTooLarge);
}

TEST(RgbeDecode, RefusesRunsThatLeaveTheirRow) {
  const auto message = [](const std::string& pixels) {
    return sample::error_of([&] { decode(sample::rgbe_header(8, 1) + pixels); }).message;
  };
  const std::string head = {2, 2, 0, 8};
  EXPECT_THAT(message(head + std::string({'\x89', 7})), testing::HasSubstr("leaves its row"));  // run of 9
  EXPECT_THAT(message(head + std::string({9, 1, 2, 3, 4, 5, 6, 7, 8, 9})),
              testing::HasSubstr("leaves its row"));
  EXPECT_THAT(message(head + std::string({0, 0, 0, 0})),
              testing::HasSubstr("leaves its row"));  // no progress
  EXPECT_THAT(message(std::string({2, 2, 0, 9}) + std::string(40, 1)), testing::HasSubstr("wrong width"));
  EXPECT_THAT(message(std::string({1, 1, 1, 4})), testing::HasSubstr("no pixel to repeat"));
  EXPECT_THAT(message(std::string({9, 9, 9, 9, 1, 1, 1, 8})), testing::HasSubstr("leaves its row"));
  EXPECT_THAT(message(std::string(28, 9)), testing::HasSubstr("ends before"));
}

}  // namespace
}  // namespace furnace
