// The same bytes in, the same pixels or words out, whichever process decodes.
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/decode/process_decoder.hpp"
#include "renderer/image/encode.hpp"

namespace furnace::decode {
namespace {

namespace fs = std::filesystem;

const fs::path kMalformed = fs::path(FURNACE_SOURCE_DIR) / ".." / "shared" / "data" / "malformed";

Decoder& process_decoder() {
  static ProcessDecoder decoder([] {
    PoolConfig config;
    config.command.program = {FURNACE_HOSTILE_WORKER};
    config.processes = 2;
    return config;
  }());
  return decoder;
}

// What a decoder made of a file: an image, or an error.
struct Made {
  std::optional<Image> image;
  RepairReport repairs;
  Error error;
};

template <class Body>
Made made_by(Body&& body) {
  Made made;
  try {
    body(made);
  } catch (const Error& error) {
    made.error = error;
  }
  return made;
}

Made texture(Decoder& decoder, const Blob& file, ColorSpace color_space, const DecodeLimits& limits) {
  return made_by([&](Made& made) { made.image = decoder.texture(file, color_space, limits, Deadline()); });
}

Made environment(Decoder& decoder, const Blob& file, const DecodeLimits& limits) {
  return made_by([&](Made& made) {
    DecodedEnvironment decoded = decoder.environment(file, limits, Deadline());
    made.image = std::move(decoded.equirect);
    made.repairs = decoded.repairs;
  });
}

void expect_equal(const Made& a, const Made& b) {
  EXPECT_EQ(a.error.message, b.error.message);
  EXPECT_EQ(a.error.code, b.error.code);
  EXPECT_EQ(a.error.pointer, b.error.pointer);
  EXPECT_EQ(a.error.detail, b.error.detail);
  EXPECT_EQ(a.repairs, b.repairs);
  ASSERT_EQ(a.image.has_value(), b.image.has_value());
  if (!a.image) return;
  EXPECT_EQ(a.image->extent, b.image->extent);
  EXPECT_EQ(a.image->channels, b.image->channels);
  EXPECT_EQ(a.image->type, b.image->type);
  EXPECT_EQ(a.image->color_space, b.image->color_space);
  EXPECT_TRUE(a.image->pixels == b.image->pixels);
}

// Both ways, each as a texture and as an environment. Returns how many of the two were decoded.
int expect_same(const Blob& file, const DecodeLimits& limits = {}) {
  const Made pixels = texture(in_process_decoder(), file, ColorSpace::kNonColor, limits);
  expect_equal(pixels, texture(process_decoder(), file, ColorSpace::kNonColor, limits));
  const Made map = environment(in_process_decoder(), file, limits);
  expect_equal(map, environment(process_decoder(), file, limits));
  return int(pixels.image.has_value()) + int(map.image.has_value());
}

Image noise(Extent extent, int channels, SampleType type, ColorSpace color_space) {
  Image image = make_image(extent, channels, type, color_space);
  std::uint32_t state = 1;
  for (std::byte& byte : image.pixels) byte = std::byte((state = state * 1664525 + 1013904223) >> 24);
  return image;
}

Image ramp(Extent extent) {
  Image image = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  float value = 0;
  for (float& sample : image.samples<float>()) sample = (value += 0.25f);
  return image;
}

TEST(Decoders, AgreeOnEveryFormat) {
  const Image rgba = noise({37, 21}, 4, SampleType::kUint8, ColorSpace::kSrgb);
  const Image rgb = noise({64, 9}, 3, SampleType::kUint8, ColorSpace::kSrgb);
  const Image fine = noise({33, 5}, 4, SampleType::kUint16, ColorSpace::kSrgb);
  Image dirty = ramp({64, 32});
  dirty.samples<float>()[100] = std::numeric_limits<float>::quiet_NaN();
  dirty.samples<float>()[200] = std::numeric_limits<float>::infinity();
  dirty.samples<float>()[300] = -1;
  std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
  for (int i = 0; i < 8; ++i) hdr += std::string({char(i * 9), char(200), char(3), char(120 + i)});
  for (const std::string& file :
       {encode_png(rgba, {}), encode_png(fine, {}), encode_jpeg(rgb, 80, {}), encode_webp(rgba, {}, {}),
        encode_webp(rgb, {.lossless = true}, {}), encode_exr(dirty, {}),
        encode_exr(dirty, {}, ExrCompression::kPiz), encode_exr(dirty, {}, ExrCompression::kDwaa), hdr}) {
    EXPECT_EQ(expect_same(Blob(file)), 1);
    EXPECT_EQ(expect_same(Blob(file.substr(0, file.size() / 2))), 0);
    EXPECT_EQ(expect_same(Blob(file), {.max_side_px = 3}), 0);  // told as kTooLarge, by name of the limit
  }
  EXPECT_EQ(expect_same(Blob()), 0);
}

TEST(Decoders, AgreeOnColorSpaceAndRepairs) {
  const Blob png(encode_png(noise({4, 4}, 3, SampleType::kUint8, ColorSpace::kSrgb), {}));
  const Image image = process_decoder().texture(png, ColorSpace::kSrgb, {}, Deadline());
  EXPECT_EQ(image.color_space, ColorSpace::kSrgb);
  Image dirty = ramp({8, 4});
  dirty.samples<float>()[7] = -3;
  const DecodedEnvironment map =
      process_decoder().environment(Blob(encode_exr(dirty, {})), DecodeLimits{}, Deadline());
  EXPECT_EQ(map.repairs.negative_samples, 1);
  EXPECT_EQ(map.equirect.samples<float>()[7], 0);
  EXPECT_EQ(map.equirect.samples<float>()[8], dirty.samples<float>()[8]);
}

TEST(Decoders, AgreeOnTheCorpusOfOthers) {
  if (!fs::exists(kMalformed)) GTEST_SKIP() << "the test data are not beside the source";
  int files = 0;
  for (const char* folder : {"exr", "hdr", "png", "jpeg", "webp"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kMalformed / folder)) {
      // Every third: each is decoded four times, and the codecs' own tests read them all.
      if (!entry.is_regular_file() || ++files % 3 != 0) continue;
      SCOPED_TRACE(entry.path());
      expect_same(Blob(read_file(entry.path(), 10 << 20)));
    }
  }
  EXPECT_GT(files, 250);
}

}  // namespace
}  // namespace furnace::decode
