#include "tests/image/sample_files.hpp"
#include "renderer/image/codecs.hpp"
#include "renderer/image/encode.hpp"
#include "renderer/base/file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <limits>

namespace furnace {
namespace {

using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

const DecodeLimits kLimits;

TEST(Sniff, GoesByMagicNumbers) {
  const auto sniff = [](const std::string& text) {
    return sniff_image_format(std::as_bytes(std::span(text)));
  };
  EXPECT_EQ(sniff(sample::png(1, 1, {0, 0, 0}, {})), ImageFormat::kPng);
  EXPECT_EQ(sniff(sample::flat_jpeg(1, 1, {0}, sample::JpegKind::kGrey)), ImageFormat::kJpeg);
  EXPECT_EQ(sniff(sample::lossless_webp(1, 1, 3, {0, 0, 0})), ImageFormat::kWebp);
  EXPECT_EQ(sniff(sample::rgbe_header(2, 1)), ImageFormat::kHdr);
  EXPECT_EQ(sniff("\x76\x2f\x31\x01"), ImageFormat::kExr);
  EXPECT_EQ(sniff(""), ImageFormat::kUnknown);
  EXPECT_EQ(sniff("RIFF1234WAVE"), ImageFormat::kUnknown);
  EXPECT_EQ(sniff("RIFF"), ImageFormat::kUnknown);
  EXPECT_EQ(image_format_name(ImageFormat::kWebp), "WebP");
}

// A 2:1 map of one value, as an EXR that stores NaN, infinities and signs as they are.
Image constant(int height, float value) {
  Image image = make_image({2 * height, height}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  std::ranges::fill(image.samples<float>(), value);
  return image;
}

float& at(Image& image, int x, int y, int channel) {
  return image.samples<float>()[static_cast<std::size_t>((y * image.extent.width + x) * 3 + channel)];
}

TEST(DecodeEnvironment, LeavesCleanFilesAlone) {
  Image image = constant(8, 0);
  float value = 0;
  for (float& sample : image.samples<float>()) sample = value += 0.25f;
  const DecodedEnvironment environment = decode_environment(Blob(encode_exr(image, {})), kLimits);
  EXPECT_EQ(environment.equirect.pixels, image.pixels);
  EXPECT_EQ(environment.repairs.nan_samples + environment.repairs.infinite_samples +
                environment.repairs.negative_samples,
            0);
}

TEST(DecodeEnvironment, MendsWhatIsNoRadiance) {
  Image image = constant(8, 2);
  at(image, 5, 4, 0) = kNan;
  at(image, 4, 3, 0) = 10;  // neighbours of the NaN: 10, six times 2, and a negative one that counts as 0
  at(image, 6, 5, 0) = -8;
  at(image, 10, 1, 0) = kInf;  // becomes the peak of its own channel
  at(image, 11, 1, 1) = kInf;
  at(image, 12, 1, 1) = -kInf;
  at(image, 0, 7, 2) = -0.5f;
  const DecodedEnvironment environment = decode_environment(Blob(encode_exr(image, {})), kLimits);
  EXPECT_EQ(environment.repairs.nan_samples, 1);
  EXPECT_EQ(environment.repairs.infinite_samples, 3);
  EXPECT_EQ(environment.repairs.negative_samples, 2);
  Image mended = environment.equirect;
  EXPECT_FLOAT_EQ(at(mended, 5, 4, 0), (10 + 6 * 2) / 8.0f);
  EXPECT_EQ(at(mended, 6, 5, 0), 0);
  EXPECT_EQ(at(mended, 10, 1, 0), 10);
  EXPECT_EQ(at(mended, 11, 1, 1), 2);
  EXPECT_EQ(at(mended, 12, 1, 1), 0);
  EXPECT_EQ(at(mended, 0, 7, 2), 0);
  EXPECT_EQ(at(mended, 4, 3, 0), 10) << "a sound sample was touched";
}

// Longitude wraps around; the mean must not depend on which of two NaNs comes first.
TEST(RepairRadiance, LooksAroundTheSphereAndOnlyAtOriginals) {
  Image image = constant(4, 1);
  at(image, 0, 1, 1) = kNan;
  at(image, 7, 1, 1) = 4;  // left of column 0
  at(image, 1, 1, 1) = kNan;
  EXPECT_EQ(repair_radiance(image).nan_samples, 2);
  EXPECT_FLOAT_EQ(at(image, 0, 1, 1), (4 + 6 * 1) / 7.0f);
  EXPECT_FLOAT_EQ(at(image, 1, 1, 1), 1);

  Image corner = constant(4, 1);
  at(corner, 0, 0, 0) = kNan;
  at(corner, 7, 1, 0) = 7;
  repair_radiance(corner);
  EXPECT_FLOAT_EQ(at(corner, 0, 0, 0), (7 + 4 * 1) / 5.0f) << "no row above the pole";
}

TEST(RepairRadiance, GivesBlackWhereNothingIsKnown) {
  Image nothing = constant(4, kNan);
  EXPECT_EQ(repair_radiance(nothing).nan_samples, 8 * 4 * 3);
  for (float sample : nothing.samples<float>()) ASSERT_EQ(sample, 0);
  Image infinite = constant(4, kInf);
  EXPECT_EQ(repair_radiance(infinite).infinite_samples, 8 * 4 * 3);
  for (float sample : infinite.samples<float>()) ASSERT_EQ(sample, 0);
}

TEST(DecodeEnvironment, WantsTwoToOne) {
  const Image square = make_image({8, 8}, 3, SampleType::kFloat32, ColorSpace::kLinear);
  const Error error = sample::error_of([&] { decode_environment(Blob(encode_exr(square, {})), kLimits); });
  EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(error.message, HasSubstr("8 x 8"));
  EXPECT_THAT(error.message, HasSubstr("resample it to 16 x 8"));
  const std::string flat = sample::rgbe_header(3, 2) + std::string(24, '\x40');
  EXPECT_EQ(sample::error_of([&] { decode_environment(Blob(flat), kLimits); }).code,
            ErrorCode::kUnprocessable);
}

TEST(Decode, SaysWhichFormatsItTakes) {
  const Blob png(sample::png(2, 1, std::vector<std::uint8_t>(6), {}));
  const Error environment = sample::error_of([&] { decode_environment(png, kLimits); });
  EXPECT_EQ(environment.code, ErrorCode::kUnsupportedMedia);
  EXPECT_THAT(environment.message, HasSubstr("this one is PNG"));
  const Blob hdr(sample::rgbe_header(2, 1) + "12345678");
  const Error texture = sample::error_of([&] { decode_texture(hdr, ColorSpace::kSrgb, kLimits); });
  EXPECT_EQ(texture.code, ErrorCode::kUnsupportedMedia);
  EXPECT_THAT(texture.message, HasSubstr("this one is Radiance HDR"));
  EXPECT_THAT(sample::error_of([&] { decode_texture(Blob(), ColorSpace::kSrgb, kLimits); }).message,
              HasSubstr("unknown"));
}

const std::filesystem::path kData = std::filesystem::path(FURNACE_SOURCE_DIR) / ".." / "shared" / "data";

// Peaks that OpenImageIO finds in these files, an independent reader; six digits of them are written down.
TEST(DecodeEnvironment, ReadsRealFilesAsOthersDo) {
  if (!std::filesystem::exists(kData / "environments"))
    GTEST_SKIP() << "the test data are not beside the source";
  const struct {
    const char* name;
    Extent extent;
    std::array<float, 3> peak;
  } kFiles[] = {
      {"KernerEnvLatLong.exr", {1024, 512}, {1678, 1678, 1678}},
      {"OrientationLatLong.exr", {1024, 512}, {0.995605f, 0.990723f, 0.990723f}},
      {"blender_city.exr", {1024, 512}, {33952, 31696, 25792}},
      {"kloofendal_48d_partly_cloudy_1k.exr", {1024, 512}, {53248, 54272, 48128}},
      {"pmndrs_sunrise_512.exr", {512, 256}, {20.7656f, 15.1797f, 15008}},
      {"narrow_moonlit_road_1k.hdr", {1024, 512}, {61440, 72192, 89088}},
      {"pedestrian_overpass_1k.hdr", {1024, 512}, {118272, 60416, 13824}},
      {"royal_esplanade_256.hdr", {256, 128}, {12608, 9600, 3776}},
      {"venice_sunset_1k.hdr", {1024, 512}, {6496, 992, 2.48438f}},
  };
  for (const auto& file : kFiles) {
    SCOPED_TRACE(file.name);
    const Blob bytes(read_file(kData / "environments" / file.name, 100 << 20));
    const DecodedEnvironment environment = decode_environment(bytes, kLimits);
    ASSERT_EQ(environment.equirect.extent, file.extent);
    std::array<float, 3> peak{};
    const auto samples = environment.equirect.samples<float>();
    for (std::size_t i = 0; i < samples.size(); ++i) peak[i % 3] = std::max(peak[i % 3], samples[i]);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(peak[i], file.peak[i], file.peak[i] * 1e-5f);
  }
}

// One place, two files, two formats: what one decoder turns around or scales, the other does not. The EXR is DWA-compressed
// and half as fine, hence 2 % of the mean.
TEST(DecodeEnvironment, HdrAndExrAgree) {
  if (!std::filesystem::exists(kData / "environments"))
    GTEST_SKIP() << "the test data are not beside the source";
  const auto load = [&](const char* name) {
    return decode_environment(Blob(read_file(kData / "environments" / name, 100 << 20)), kLimits).equirect;
  };
  const Image hdr = load("venice_sunset_1k.hdr"), exr = load("blender_sunset.exr");
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < hdr.samples<float>().size(); ++i) {
    difference += std::abs(hdr.samples<float>()[i] - exr.samples<float>()[i]);
    sum += hdr.samples<float>()[i];
  }
  EXPECT_LT(difference, 0.02 * sum);
}

TEST(DecodeExr, ReadsFilesFullOfNanAndInf) {
  const auto folder = kData / "malformed" / "exr" / "nan-inf";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the test data are not beside the source";
  const auto repairs_of = [&](const char* name) {
    const Blob bytes(read_file(folder / name, 10 << 20));
    Image image = decode_exr(bytes.bytes(), kLimits, Shape::kAny);
    const RepairReport report = repair_radiance(image);
    for (float sample : image.samples<float>()) EXPECT_TRUE(sample >= 0 && sample <= 65504.0f);
    return report;
  };
  // Every half once: 2 x 1023 NaN, two infinities, and what is below zero; three channels.
  const RepairReport halves = repairs_of("AllHalfValues.exr");
  EXPECT_EQ(halves.nan_samples, 3 * 2 * 1023);
  EXPECT_EQ(halves.infinite_samples, 3 * 2);
  EXPECT_EQ(halves.negative_samples, 3 * (0xfc00 - 0x8001));
  const RepairReport rings = repairs_of("BrightRingsNanInf.exr");
  EXPECT_GT(rings.nan_samples, 0);
  EXPECT_GT(rings.infinite_samples, 0);
}

// Files that crashed others: each gives an error or a picture. That this program ends well is the test.
TEST(Decode, SurvivesTheCorpusOfOthers) {
  if (!std::filesystem::exists(kData / "malformed"))
    GTEST_SKIP() << "the test data are not beside the source";
  int files = 0;
  for (const char* folder : {"exr", "hdr", "png", "jpeg", "webp"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(kData / "malformed" / folder)) {
      if (!entry.is_regular_file()) continue;
      const Blob bytes(read_file(entry.path(), 10 << 20));
      ++files;
      for (const auto& decode : std::initializer_list<std::function<void()>>{
               [&] { decode_texture(bytes, ColorSpace::kSrgb, kLimits); },
               [&] { decode_environment(bytes, kLimits); },
               [&] { decode_exr(bytes.bytes(), kLimits, Shape::kAny); },
               [&] { decode_rgbe(bytes.bytes(), kLimits, Shape::kAny); }}) {
        try {
          decode();
        } catch (const Error& error) {
          EXPECT_FALSE(error.message.empty()) << entry.path();
          EXPECT_NE(error.code, ErrorCode::kInternal) << entry.path();
        }
      }
    }
  }
  EXPECT_GT(files, 250);
}

}  // namespace
}  // namespace furnace
