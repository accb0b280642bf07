#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstring>
#include <map>

namespace furnace {
namespace {

using sample::PngOptions;

const DecodeLimits kLimits;

Image decode(const std::string& file) {
  return sample::picture(file, ColorSpace::kNonColor, kLimits);
}

std::size_t stored_channels(int color_type) {
  return color_type == 2 ? 3 : color_type == 4 ? 2 : color_type == 6 ? 4 : 1;
}

std::size_t stride(int width, const PngOptions& options) {
  return (static_cast<std::size_t>(width) * stored_channels(options.color_type) *
              static_cast<std::size_t>(options.depth) +
          7) /
         8;
}

// Sample `index` of a stored row.
std::uint32_t stored_sample(const std::uint8_t* row, std::size_t index, int depth) {
  std::uint32_t value = 0;
  for (int bit = 0; bit < depth; ++bit) {
    const std::size_t place = index * static_cast<std::size_t>(depth) + static_cast<std::size_t>(bit);
    value = value * 2 + (row[place / 8] >> (7 - place % 8) & 1);
  }
  return value;
}

std::uint32_t decoded_sample(const Image& image, int x, int y, int channel) {
  const std::size_t index = (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.extent.width) +
                             static_cast<std::size_t>(x)) *
                                static_cast<std::size_t>(image.channels) +
                            static_cast<std::size_t>(channel);
  return image.type == SampleType::kUint16 ? image.samples<std::uint16_t>()[index]
                                           : image.samples<std::uint8_t>()[index];
}

// Random pixels, what libpng makes of them, and what they must be when read: the judge reads the bits one by one.
void expect_round_trip(int width, int height, PngOptions options, std::uint32_t seed) {
  SCOPED_TRACE(testing::Message() << "type " << options.color_type << ", " << options.depth << " bits, "
                                  << width << " x " << height << (options.interlaced ? ", interlaced" : "")
                                  << ", filters " << options.filters
                                  << (options.transparency.empty() ? "" : ", transparency"));
  const std::size_t row_bytes = stride(width, options);
  const auto rows = sample::noise(row_bytes * static_cast<std::size_t>(height), seed);
  const Image image = decode(sample::png(width, height, rows, options));

  const bool is_palette = options.color_type == 3;
  const std::size_t stored = stored_channels(options.color_type);
  const std::size_t colors = is_palette ? 3 : stored;
  ASSERT_EQ(image.extent, (Extent{width, height}));
  ASSERT_EQ(image.channels, static_cast<int>(colors + (options.transparency.empty() ? 0 : 1)));
  ASSERT_EQ(image.type, options.depth == 16 ? SampleType::kUint16 : SampleType::kUint8);
  ASSERT_EQ(image.color_space, ColorSpace::kNonColor);
  const std::uint32_t spread = options.depth < 8 ? 255 / ((1u << options.depth) - 1) : 1;
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = rows.data() + static_cast<std::size_t>(y) * row_bytes;
    for (int x = 0; x < width; ++x) {
      bool is_key = true;
      for (std::size_t channel = 0; channel < colors; ++channel) {
        std::uint32_t expected;
        if (is_palette) {
          const std::size_t entry = stored_sample(row, static_cast<std::size_t>(x), options.depth);
          const bool is_listed = entry * 3 < options.palette.size();
          expected = is_listed ? static_cast<std::uint8_t>(options.palette[entry * 3 + channel]) : 0;
        } else {
          const std::uint32_t value =
              stored_sample(row, static_cast<std::size_t>(x) * stored + channel, options.depth);
          if (!options.transparency.empty()) {
            const auto* key =
                reinterpret_cast<const std::uint8_t*>(options.transparency.data()) + 2 * channel;
            is_key = is_key && value == static_cast<std::uint32_t>(key[0] << 8 | key[1]);
          }
          expected = value * spread;
        }
        ASSERT_EQ(decoded_sample(image, x, y, static_cast<int>(channel)), expected)
            << x << ", " << y << ", " << channel;
      }
      if (options.transparency.empty()) continue;
      std::uint32_t alpha = is_key ? 0 : options.depth == 16 ? 65535 : 255;
      if (is_palette) {
        const std::size_t entry = stored_sample(row, static_cast<std::size_t>(x), options.depth);
        alpha = entry < options.transparency.size() ? static_cast<std::uint8_t>(options.transparency[entry])
                                                    : 255;
      }
      ASSERT_EQ(decoded_sample(image, x, y, image.channels - 1), alpha) << x << ", " << y;
    }
  }
}

const std::map<int, std::vector<int>> kDepths = {
    {0, {1, 2, 4, 8, 16}}, {2, {8, 16}}, {3, {1, 2, 4, 8}}, {4, {8, 16}}, {6, {8, 16}}};

std::string random_text(std::size_t size, std::uint32_t seed) {
  const auto bytes = sample::noise(size, seed);
  return {bytes.begin(), bytes.end()};
}

PngOptions options_of(int type, int depth) {
  PngOptions options{.color_type = type, .depth = depth};
  if (type == 3) options.palette = random_text(3u << depth, 5);
  return options;
}

TEST(PngDecode, ReadsEveryTypeAndDepth) {
  std::uint32_t seed = 0;
  for (const auto& [type, depths] : kDepths) {
    for (int depth : depths) {
      for (bool interlaced : {false, true}) {
        PngOptions options = options_of(type, depth);
        options.interlaced = interlaced;
        // 1 to 9: every length of a row that Adam7 and packed bits can leave over.
        for (int size = 1; size <= 9; ++size) expect_round_trip(size, 10 - size, options, ++seed);
        expect_round_trip(33, 17, options, ++seed);
      }
    }
  }
}

TEST(PngDecode, UndoesEveryFilter) {
  for (const auto& [type, depths] : kDepths) {
    for (int depth : depths) {
      PngOptions options = options_of(type, depth);
      for (int filter : {PNG_FILTER_NONE, PNG_FILTER_SUB, PNG_FILTER_UP, PNG_FILTER_AVG, PNG_FILTER_PAETH}) {
        options.filters = filter;
        expect_round_trip(37, 11, options, 99);
      }
    }
  }
}

TEST(PngDecode, MakesAlphaOfTransparency) {
  for (bool interlaced : {false, true}) {
    PngOptions palette = options_of(3, 4);
    palette.interlaced = interlaced;
    palette.transparency = random_text(7, 3);  // fewer than colours: the rest is opaque
    expect_round_trip(21, 9, palette, 1);
    PngOptions grey{
        .color_type = 0, .depth = 2, .interlaced = interlaced, .transparency = std::string("\0\2", 2)};
    expect_round_trip(21, 9, grey, 2);
    PngOptions rgb{.color_type = 2, .depth = 8, .interlaced = interlaced};
    const auto rows =
        sample::noise(21 * 9 * 3, 3);  // the same as in the round trip: its first pixel is the key
    for (int i = 0; i < 3; ++i)
      rgb.transparency += {'\0', static_cast<char>(rows[static_cast<std::size_t>(i)])};
    expect_round_trip(21, 9, rgb, 3);
    PngOptions deep{.color_type = 0, .depth = 16, .interlaced = interlaced};
    const auto deep_rows = sample::noise(21 * 9 * 2, 4);
    deep.transparency = {static_cast<char>(deep_rows[0]), static_cast<char>(deep_rows[1])};
    expect_round_trip(21, 9, deep, 4);
  }
}

TEST(PngDecode, ChecksLimitsFirst) {
  const std::string file = sample::png(20, 10, std::vector<std::uint8_t>(600), {});
  const auto code = [&](const DecodeLimits& limits) {
    return sample::error_of([&] { decode_texture(Blob(file), ColorSpace::kSrgb, limits); }).code;
  };
  EXPECT_EQ(code({.max_side_px = 20, .max_area_px = 199}), ErrorCode::kTooLarge);
  EXPECT_NO_THROW(decode_texture(Blob(file), ColorSpace::kSrgb, {.max_side_px = 20, .max_area_px = 200}));
}

// A file of 60 bytes cannot hold 16384 x 3000 pixels; it is refused without memory for them.
TEST(PngDecode, DoesNotBelieveHeaders) {
  std::string file = sample::png(1, 1, {1, 2, 3}, {});
  const auto set_be32 = [&](std::size_t at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
      file[at + static_cast<std::size_t>(i)] = static_cast<char>(value >> (24 - 8 * i));
  };
  set_be32(16, 16384);
  set_be32(20, 3000);
  std::uint32_t crc = 0xffffffff;
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<std::uint8_t>(file[i]);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  set_be32(29, ~crc);
  const Error error = sample::error_of([&] { decode(file); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.message, testing::HasSubstr("ends before its last pixel"));
}

Image gradient(int width, int height, int channels) {
  Image image = make_image({width, height}, channels, SampleType::kUint8, ColorSpace::kSrgb);
  std::mt19937 random(7);
  const auto samples = image.samples<std::uint8_t>();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<std::uint8_t>(i / 7 + sample::next(random, 4));
  }
  return image;
}

// libpng's own reading of a file: pixels and what it says about them.
struct Judged {
  int color_type = 0, depth = 0, srgb_intent = -1;
  std::vector<std::uint8_t> rows;
  std::map<std::string, std::string> texts;
};

Judged judge(const std::string& file) {
  Judged judged;
  png_structp png = png_create_read_struct(
      PNG_LIBPNG_VER_STRING, nullptr,
      [](png_structp, png_const_charp text) { throw std::runtime_error(text); },
      [](png_structp, png_const_charp text) { throw std::runtime_error(text); });
  png_infop info = png_create_info_struct(png);
  std::string_view left = file;
  png_set_read_fn(png, &left, [](png_structp p, png_bytep out, std::size_t size) {
    auto& bytes = *static_cast<std::string_view*>(png_get_io_ptr(p));
    if (size > bytes.size()) throw std::runtime_error("the file ends too early");
    std::memcpy(out, bytes.data(), size);
    bytes.remove_prefix(size);
  });
  png_read_info(png, info);
  judged.color_type = png_get_color_type(png, info);
  judged.depth = png_get_bit_depth(png, info);
  png_get_sRGB(png, info, &judged.srgb_intent);
  const std::size_t stride = png_get_rowbytes(png, info);
  judged.rows.resize(stride * png_get_image_height(png, info));
  for (std::size_t at = 0; at < judged.rows.size(); at += stride)
    png_read_row(png, judged.rows.data() + at, nullptr);
  png_read_end(png, info);
  EXPECT_TRUE(left.empty());
  png_textp texts = nullptr;
  const int count = png_get_text(png, info, &texts, nullptr);
  for (int i = 0; i < count; ++i) judged.texts[texts[i].key] = texts[i].text;
  png_destroy_read_struct(&png, &info, nullptr);
  return judged;
}

TEST(PngEncode, IsReadByLibpng) {
  for (int channels = 1; channels <= 4; ++channels) {
    for (const Extent extent : {Extent{1, 1}, Extent{1, 9}, Extent{9, 1}, Extent{64, 48}, Extent{333, 257}}) {
      const Image image = gradient(extent.width, extent.height, channels);
      const Judged judged = judge(encode_png(image, {}));
      ASSERT_EQ(judged.depth, 8);
      ASSERT_EQ(stored_channels(judged.color_type), static_cast<std::size_t>(channels));
      ASSERT_EQ(judged.srgb_intent, PNG_sRGB_INTENT_PERCEPTUAL);
      ASSERT_TRUE(std::ranges::equal(judged.rows, image.samples<std::uint8_t>()));
    }
  }
}

// For readers that do not know the sRGB chunk. libpng, whose warnings count here, compares the two.
TEST(PngEncode, SaysWhatSrgbIsInNumbers) {
  const std::string file = encode_png(gradient(4, 4, 3), {});
  const auto numbers_of = [&](std::string_view chunk) {
    std::vector<std::uint32_t> numbers;
    const std::size_t at = file.find(chunk);
    if (at > file.find("IDAT")) return numbers;
    const auto byte = [&](std::size_t i) { return std::uint32_t(static_cast<unsigned char>(file[i])); };
    const auto number = [&](std::size_t i) {
      return byte(i) << 24 | byte(i + 1) << 16 | byte(i + 2) << 8 | byte(i + 3);
    };
    for (std::uint32_t i = 0; i < number(at - 4); i += 4) numbers.push_back(number(at + 4 + i));
    return numbers;
  };
  EXPECT_EQ(numbers_of("gAMA"), std::vector<std::uint32_t>{45455});  // 1 / 2.2
  EXPECT_EQ(numbers_of("cHRM"),
            (std::vector<std::uint32_t>{31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000}));
  EXPECT_EQ(judge(file).srgb_intent, PNG_sRGB_INTENT_PERCEPTUAL);
}

TEST(PngEncode, SixteenBitsAreReadByLibpng) {
  for (const int channels : {3, 4}) {
    Image image = make_image({33, 21}, channels, SampleType::kUint16, ColorSpace::kSrgb);
    const auto bytes = sample::noise(image.byte_size(), 7);
    std::memcpy(image.pixels.data(), bytes.data(), bytes.size());
    const std::string file = encode_png(image, {});
    const Judged judged = judge(file);
    ASSERT_EQ(judged.depth, 16);
    ASSERT_EQ(judged.srgb_intent, PNG_sRGB_INTENT_PERCEPTUAL);
    const auto samples = image.samples<std::uint16_t>();
    ASSERT_EQ(judged.rows.size(), 2 * samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
      ASSERT_EQ(judged.rows[2 * i] << 8 | judged.rows[2 * i + 1], samples[i]) << i;
    EXPECT_EQ(decode(file).pixels, image.pixels);
  }
}

TEST(PngEncode, IsReadBack) {
  const Image image = gradient(100, 80, 4);
  const Image back = sample::picture(encode_png(image, {}), ColorSpace::kSrgb, kLimits);
  EXPECT_EQ(back.pixels, image.pixels);
  EXPECT_EQ(back.channels, 4);
}

TEST(PngEncode, WritesMetadata) {
  const std::vector<TextField> fields = {{"Software", "Furnace 1"}, {"Title", "gr\xc3\xbcn"}, {"Empty", ""}};
  const Judged judged = judge(encode_png(gradient(4, 4, 3), fields));
  EXPECT_THAT(judged.texts, testing::UnorderedElementsAre(testing::Pair("Software", "Furnace 1"),
                                                          testing::Pair("Title", "gr\xc3\xbcn"),
                                                          testing::Pair("Empty", "")));
}

TEST(PngEncode, GivesTheSameBytesForTheSameImage) {
  EXPECT_EQ(encode_png(gradient(64, 64, 3), {{"a", "b"}}), encode_png(gradient(64, 64, 3), {{"a", "b"}}));
}

TEST(PngEncode, TagsOnlySrgb) {
  Image mask = gradient(4, 4, 1);
  mask.color_space = ColorSpace::kNonColor;
  EXPECT_EQ(judge(encode_png(mask, {})).srgb_intent, -1);
}

TEST(PngEncodeDeathTest, RefusesOtherSampleTypes) {
  const Image image = make_image({1, 1}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  EXPECT_DEATH(encode_png(image, {}), "sample type");
}

}  // namespace
}  // namespace furnace
