#include "tests/image/sample_files.hpp"
#include "renderer/image/codecs.hpp"
#include "renderer/image/encode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <cmath>
#include <functional>
#include <limits>

namespace furnace {
namespace {

using testing::HasSubstr;

const DecodeLimits kLimits;

Image decode(const std::string& file) {
  return decode_exr(std::as_bytes(std::span(file)), kLimits, Shape::kAny);
}

Error error_of(const std::string& file) {
  return sample::error_of([&] { decode(file); });
}

// Half-representable, so that every pixel type stores it exactly; whole numbers for UINT.
float value_at(int x, int y, int channel) {
  return static_cast<float>((x * 3 + y * 5 + channel * 7) % 97);
}

// The pixels of a data window, for OpenEXR to write; `names[i]` gets value_at(x, y, i).
class Pixels {
 public:
  Pixels(const Imath::Box2i& window, const std::vector<std::string>& names, Imf::PixelType type)
      : width_(width(window)) {
    const std::size_t area = width_ * static_cast<std::size_t>(window.max.y - window.min.y + 1);
    data_.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::size_t size = type == Imf::HALF ? 2 : 4;
      data_[i].resize(area * size);
      for (int y = window.min.y; y <= window.max.y; ++y) {
        for (int x = window.min.x; x <= window.max.x; ++x) {
          const float value = value_at(x, y, static_cast<int>(i));
          char* const place = data_[i].data() + index(window, x, y) * size;
          if (type == Imf::HALF) *reinterpret_cast<std::uint16_t*>(place) = half_from_float(value);
          if (type == Imf::FLOAT) *reinterpret_cast<float*>(place) = value;
          if (type == Imf::UINT) *reinterpret_cast<std::uint32_t*>(place) = static_cast<std::uint32_t>(value);
        }
      }
      frame.insert(names[i], Imf::Slice::Make(type, data_[i].data(), window, size, width_ * size));
    }
  }

  Imf::FrameBuffer frame;

 private:
  static std::size_t width(const Imath::Box2i& window) {
    return static_cast<std::size_t>(window.max.x - window.min.x + 1);
  }
  std::size_t index(const Imath::Box2i& window, int x, int y) const {
    return static_cast<std::size_t>(y - window.min.y) * width_ + static_cast<std::size_t>(x - window.min.x);
  }

  std::size_t width_;
  std::vector<std::vector<char>> data_;
};

struct ExrOptions {
  Imath::Box2i display{{0, 0}, {39, 19}};
  Imath::Box2i data = display;
  std::vector<std::string> names = {"R", "G", "B"};
  Imf::PixelType type = Imf::HALF;
  Imf::Compression compression = Imf::ZIP_COMPRESSION;
  Imf::LineOrder order = Imf::INCREASING_Y;
};

Imf::Header header_of(const ExrOptions& options) {
  Imf::Header header(options.display, options.data, 1, {0, 0}, 1, options.order, options.compression);
  for (const std::string& name : options.names) header.channels().insert(name, Imf::Channel(options.type));
  return header;
}

std::string scanline_file(const ExrOptions& options) {
  const Pixels pixels(options.data, options.names, options.type);
  Imf::StdOSStream stream;
  {
    Imf::OutputFile file(stream, header_of(options), 0);
    file.setFrameBuffer(pixels.frame);
    file.writePixels(options.data.max.y - options.data.min.y + 1);
  }
  return stream.str();
}

std::string tiled_file(const ExrOptions& options, Imf::LevelMode mode, Imf::LevelRoundingMode rounding) {
  Imf::StdOSStream stream;
  Imf::Header header = header_of(options);
  header.setTileDescription(Imf::TileDescription(16, 8, mode, rounding));
  {
    Imf::TiledOutputFile file(stream, header, 0);
    for (int ly = 0; ly < file.numYLevels(); ++ly) {
      for (int lx = 0; lx < file.numXLevels(); ++lx) {
        if (!file.isValidLevel(lx, ly)) continue;
        const Pixels pixels(file.dataWindowForLevel(lx, ly), options.names, options.type);
        file.setFrameBuffer(pixels.frame);
        file.writeTiles(0, file.numXTiles(lx) - 1, 0, file.numYTiles(ly) - 1, lx, ly);
      }
    }
  }
  return stream.str();
}

// `channel_of[i]` is the written channel that comes out as R, G or B.
void expect_values(const Image& image, const ExrOptions& options,
                   const std::array<int, 3>& channel_of = {0, 1, 2}) {
  const int width = options.display.max.x - options.display.min.x + 1;
  const int height = options.display.max.y - options.display.min.y + 1;
  ASSERT_EQ(image.extent, (Extent{width, height}));
  ASSERT_EQ(image.channels, 3);
  ASSERT_EQ(image.type, SampleType::kFloat32);
  ASSERT_EQ(image.color_space, ColorSpace::kLinear);
  std::size_t i = 0;
  for (int y = options.display.min.y; y <= options.display.max.y; ++y) {
    for (int x = options.display.min.x; x <= options.display.max.x; ++x) {
      for (int channel = 0; channel < 3; ++channel, ++i) {
        const bool is_there = options.data.intersects(Imath::V2i(x, y));
        const float expected =
            is_there ? value_at(x, y, channel_of[static_cast<std::size_t>(channel)]) : 0.0f;
        ASSERT_EQ(image.samples<float>()[i], expected) << x << ", " << y << ", " << channel;
      }
    }
  }
}

TEST(ExrDecode, ReadsEveryTypeAndLosslessCompression) {
  for (Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
    for (Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION,
                                         Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
      SCOPED_TRACE(testing::Message() << "type " << type << ", compression " << compression);
      const ExrOptions options{.type = type, .compression = compression};
      expect_values(decode(scanline_file(options)), options);
      expect_values(decode(tiled_file(options, Imf::ONE_LEVEL, Imf::ROUND_DOWN)), options);
    }
  }
}

// PXR24 keeps halves; B44 and DWA are lossy: a few percent of the largest value, 96.
TEST(ExrDecode, ReadsLossyCompressions) {
  const ExrOptions exact{.compression = Imf::PXR24_COMPRESSION};
  expect_values(decode(scanline_file(exact)), exact);
  for (Imf::Compression compression :
       {Imf::B44_COMPRESSION, Imf::B44A_COMPRESSION, Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION}) {
    const Image image = decode(scanline_file({.compression = compression}));
    double sum = 0;
    std::size_t i = 0;
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 40; ++x) {
        for (int channel = 0; channel < 3; ++channel)
          sum += std::abs(image.samples<float>()[i++] - value_at(x, y, channel));
      }
    }
    EXPECT_LT(sum / static_cast<double>(i), 5) << compression;
  }
}

TEST(ExrDecode, ReadsTheFirstLevelOfMipMaps) {
  const ExrOptions options{.display = {{0, 0}, {64, 32}}, .data = {{0, 0}, {64, 32}}};
  for (Imf::LevelRoundingMode rounding : {Imf::ROUND_DOWN, Imf::ROUND_UP}) {
    expect_values(decode(tiled_file(options, Imf::MIPMAP_LEVELS, rounding)), options);
    expect_values(decode(tiled_file(options, Imf::RIPMAP_LEVELS, rounding)), options);
  }
}

TEST(ExrDecode, PlacesTheDataWindowInTheDisplayWindow) {
  const Imath::Box2i display{{10, -5}, {49, 14}};
  const std::vector<Imath::Box2i> windows = {
      {{20, 0}, {29, 9}},     // inside
      {{0, -20}, {99, 40}},   // all around
      {{-30, -30}, {12, 2}},  // over the upper left corner
      {{49, 14}, {80, 30}},   // one pixel in common
  };
  for (const Imath::Box2i& data : windows) {
    SCOPED_TRACE(testing::Message() << data.min.x << ", " << data.min.y);
    for (Imf::LineOrder order : {Imf::INCREASING_Y, Imf::DECREASING_Y}) {
      const ExrOptions options{.display = display, .data = data, .order = order};
      expect_values(decode(scanline_file(options)), options);
    }
    const ExrOptions options{.display = display, .data = data};
    expect_values(decode(tiled_file(options, Imf::ONE_LEVEL, Imf::ROUND_DOWN)), options);
  }
  EXPECT_THAT(error_of(scanline_file({.display = display, .data = {{60, 0}, {69, 9}}})).message,
              HasSubstr("outside"));
}

TEST(ExrDecode, ReadsLuminanceAsGrey) {
  const ExrOptions options{.names = {"Y"}};
  expect_values(decode(scanline_file(options)), options, {0, 0, 0});
}

TEST(ExrDecode, ChoosesItsChannelsAmongOthers) {
  const ExrOptions options{.names = {"A", "Z", "G", "R", "depth.V", "B", "Y"}};
  expect_values(decode(scanline_file(options)), options, {3, 2, 5});
}

std::string two_parts(const ExrOptions& first, const ExrOptions& second) {
  Imf::StdOSStream stream;
  std::vector<Imf::Header> headers = {header_of(first), header_of(second)};
  headers[0].setName("first");
  headers[1].setName("second");
  for (Imf::Header& header : headers) header.setType(Imf::SCANLINEIMAGE);
  const Pixels pixels[] = {{first.data, first.names, first.type}, {second.data, second.names, second.type}};
  {
    Imf::MultiPartOutputFile file(stream, headers.data(), 2, false, 0);
    for (int part = 0; part < 2; ++part) {
      Imf::OutputPart output(file, part);
      output.setFrameBuffer(pixels[part].frame);
      output.writePixels(20);
    }
  }
  return stream.str();
}

TEST(ExrDecode, ReadsTheFirstPartWithColour) {
  const ExrOptions depth{.names = {"Z"}}, color{.names = {"R", "G", "B", "A"}};
  expect_values(decode(two_parts(depth, color)), color);
  expect_values(decode(two_parts(color, depth)), color);
}

TEST(ExrDecode, SaysWhatItDoesNotRead) {
  const Error no_color = error_of(scanline_file({.names = {"Z"}}));
  EXPECT_EQ(no_color.code, ErrorCode::kUnsupportedMedia);
  EXPECT_THAT(no_color.message, HasSubstr("R, G and B"));
  const Error chroma = error_of(scanline_file({.names = {"Y", "RY", "BY"}}));
  EXPECT_EQ(chroma.code, ErrorCode::kUnsupportedMedia);
  EXPECT_THAT(chroma.message, HasSubstr("chroma"));
}

TEST(ExrDecode, ChecksLimitsFirst) {
  const std::string file = scanline_file({});
  const auto code = [&](const DecodeLimits& limits) {
    return sample::error_of([&] { decode_exr(std::as_bytes(std::span(file)), limits, Shape::kAny); }).code;
  };
  EXPECT_EQ(code({.max_side_px = 39}), ErrorCode::kTooLarge);
  EXPECT_EQ(code({.max_area_px = 799}), ErrorCode::kTooLarge);
  // A small picture may not hide behind large data either.
  const std::string overscan = scanline_file({.data = {{-500, 0}, {500, 19}}});
  EXPECT_EQ(sample::error_of([&] {
              decode_exr(std::as_bytes(std::span(overscan)), {.max_side_px = 1000}, Shape::kAny);
            }).code,
            ErrorCode::kTooLarge);
}

// Replaces the four bytes after the header attribute `name` (its type and size skipped) at `offset`.
std::string patched(std::string file, const std::string& name, std::size_t offset, std::int32_t value) {
  const std::size_t at = file.find(name + '\0');
  EXPECT_NE(at, std::string::npos);
  const std::size_t type = at + name.size() + 1, size = file.find('\0', type) + 1;
  file.replace(size + 4 + offset, 4, reinterpret_cast<const char*>(&value), 4);
  return file;
}

TEST(ExrDecode, DoesNotBelieveHeaders) {
  const std::string file = scanline_file({.compression = Imf::NO_COMPRESSION});
  const auto claims = [&](std::int32_t max_x, std::int32_t max_y) {
    return error_of(patched(patched(file, "dataWindow", 8, max_x), "dataWindow", 12, max_y)).code;
  };
  EXPECT_EQ(claims(16383, 3000), ErrorCode::kUnprocessable);  // within the limits, but no table for it
  EXPECT_EQ(claims(100'000, 19), ErrorCode::kTooLarge);
  EXPECT_EQ(claims(39, -1), ErrorCode::kUnprocessable);
  EXPECT_EQ(claims(-5, 19), ErrorCode::kUnprocessable);
  const std::int32_t lowest = std::numeric_limits<std::int32_t>::min(),
                     highest = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(error_of(patched(patched(file, "dataWindow", 0, lowest), "dataWindow", 8, highest)).code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(error_of(patched(patched(file, "displayWindow", 4, highest), "displayWindow", 12, highest)).code,
            ErrorCode::kUnprocessable);

  const std::string tiled = tiled_file({}, Imf::MIPMAP_LEVELS, Imf::ROUND_DOWN);
  EXPECT_EQ(error_of(patched(tiled, "tiles", 0, 0)).code, ErrorCode::kUnprocessable);
  EXPECT_EQ(error_of(patched(tiled, "tiles", 0, highest)).code, ErrorCode::kTooLarge);
  EXPECT_EQ(error_of(patched(tiled, "tiles", 0, 1)).code,
            ErrorCode::kUnprocessable);  // more tiles than bytes
}

// What encode_exr writes, as OpenEXR itself understands it.
TEST(ExrEncode, IsReadByOpenExr) {
  for (SampleType type : {SampleType::kFloat16, SampleType::kFloat32}) {
    for (int channels = 1; channels <= 4; ++channels) {
      const Extent extent{37, 41};
      Image image = make_image(extent, channels, type, ColorSpace::kLinear);
      std::vector<float> values(static_cast<std::size_t>(extent.area()) * static_cast<std::size_t>(channels));
      std::mt19937 random(3);
      for (float& value : values)
        value = float_from_half(static_cast<std::uint16_t>(sample::next(random, 0x7c00)));
      if (type == SampleType::kFloat16) {
        half_from_float(values, image.samples<std::uint16_t>());
      } else {
        std::ranges::copy(values, image.samples<float>().begin());
      }
      const std::string bytes = encode_exr(image, {{"furnace.version", "1"}, {"comments", "gr\xc3\xbcn"}});

      Imf::StdISStream stream;
      stream.str(bytes);
      Imf::InputFile file(stream, 0);
      const Imf::Header& header = file.header();
      EXPECT_EQ(header.dataWindow(), Imath::Box2i({0, 0}, {36, 40}));
      EXPECT_EQ(header.findTypedAttribute<Imf::StringAttribute>("furnace.version")->value(), "1");
      EXPECT_EQ(header.findTypedAttribute<Imf::StringAttribute>("comments")->value(), "gr\xc3\xbcn");
      const std::vector<std::string> names[] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
      std::vector<float> back(values.size());
      Imf::FrameBuffer frame;
      for (int i = 0; i < channels; ++i) {
        const std::string& name = names[channels - 1][static_cast<std::size_t>(i)];
        ASSERT_NE(header.channels().findChannel(name), nullptr) << name;
        ASSERT_EQ(header.channels()[name].type, type == SampleType::kFloat16 ? Imf::HALF : Imf::FLOAT);
        const std::size_t pixel = 4 * static_cast<std::size_t>(channels);
        frame.insert(name,
                     Imf::Slice::Make(Imf::FLOAT, back.data() + i, header.dataWindow(), pixel, pixel * 37));
      }
      file.setFrameBuffer(frame);
      file.readPixels(0, 40);
      ASSERT_EQ(back, values);
    }
  }
}

TEST(ExrEncode, IsReadBack) {
  Image image = make_image({64, 32}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  std::mt19937 random(1);
  for (float& sample : image.samples<float>())
    sample = static_cast<float>(sample::next(random, 1 << 20)) * 0x1p-10f;
  EXPECT_EQ(decode(encode_exr(image, {})).pixels, image.pixels);
}

TEST(ExrEncode, EveryCompressionIsWhatItSays) {
  Image image = make_image({64, 70}, 4, SampleType::kFloat16, ColorSpace::kLinear);
  std::vector<float> values(image.samples<std::uint16_t>().size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = 0.5f + 0.25f * std::sin(0.01f * static_cast<float>(i % 997));
  half_from_float(values, image.samples<std::uint16_t>());
  const std::pair<ExrCompression, Imf::Compression> kCompressions[] = {
      {ExrCompression::kNone, Imf::NO_COMPRESSION},
      {ExrCompression::kZip, Imf::ZIP_COMPRESSION},
      {ExrCompression::kPiz, Imf::PIZ_COMPRESSION},
      {ExrCompression::kDwaa, Imf::DWAA_COMPRESSION}};
  for (const auto& [compression, stored] : kCompressions) {
    const std::string bytes = encode_exr(image, {}, compression);
    EXPECT_EQ(encode_exr(image, {}, compression), bytes);
    Imf::StdISStream stream;
    stream.str(bytes);
    Imf::InputFile file(stream, 0);
    EXPECT_EQ(file.header().compression(), stored);
    std::vector<float> red(64u * 70u);
    Imf::FrameBuffer frame;
    frame.insert("R", Imf::Slice::Make(Imf::FLOAT, red.data(), file.header().dataWindow()));
    file.setFrameBuffer(frame);
    file.readPixels(0, 69);
    // DWAA at its level 45 quantises what eyes hardly see: at jumps, up to 4 % of such values.
    const double tolerance = compression == ExrCompression::kDwaa ? 2e-2 : 0;
    for (std::size_t i = 0; i < red.size(); ++i)
      ASSERT_NEAR(red[i], float_from_half(image.samples<std::uint16_t>()[4 * i]), tolerance) << i;
  }
}

TEST(ExrEncode, IsTaggedWithItsPrimaries) {
  Imf::StdISStream stream;
  stream.str(encode_exr(make_image({2, 2}, 3, SampleType::kFloat16, ColorSpace::kLinear), {}));
  const Imf::InputFile file(stream, 0);
  ASSERT_TRUE(Imf::hasChromaticities(file.header()));
  // ITU-R BT.709, item 1.
  const Imf::Chromaticities& tagged = Imf::chromaticities(file.header());
  EXPECT_EQ(tagged.red, Imath::V2f(0.64f, 0.33f));
  EXPECT_EQ(tagged.green, Imath::V2f(0.30f, 0.60f));
  EXPECT_EQ(tagged.blue, Imath::V2f(0.15f, 0.06f));
  EXPECT_EQ(tagged.white, Imath::V2f(0.3127f, 0.3290f));
}

TEST(ExrEncode, GivesTheSameBytesForTheSameImage) {
  const Image image = make_image({64, 32}, 4, SampleType::kFloat16, ColorSpace::kLinear);
  const std::string bytes = encode_exr(image, {{"a", "b"}});
  EXPECT_EQ(encode_exr(image, {{"a", "b"}}), bytes);
  EXPECT_THAT(bytes, Not(HasSubstr("capDate")));
}

TEST(ExrEncodeDeathTest, RefusesOtherSampleTypes) {
  EXPECT_DEATH(encode_exr(make_image({1, 1}, 3, SampleType::kUint8, ColorSpace::kLinear), {}), "sample type");
}

}  // namespace
}  // namespace furnace
