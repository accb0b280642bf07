// The same bytes in, the same pixels or words out, whichever process decodes.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zstd.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/decode/process_decoder.hpp"
#include "renderer/image/encode.hpp"
#include "tests/image/ktx2_files.hpp"
#include "tests/image/sample_files.hpp"

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

// What a decoder made of a file: images, or an error.
struct Made {
  std::vector<Image> images;
  std::vector<std::string> remarks;
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
  return made_by([&](Made& made) {
    DecodedTexture decoded = decoder.texture(file, color_space, limits, Deadline());
    made.images = std::move(decoded.levels);
    for (const TextureRemark& remark : decoded.remarks)
      made.remarks.push_back(remark.code + ": " + remark.message);
  });
}

Made environment(Decoder& decoder, const Blob& file, const DecodeLimits& limits) {
  return made_by([&](Made& made) {
    DecodedEnvironment decoded = decoder.environment(file, EnvironmentLayout::kAuto, limits, Deadline());
    made.images.push_back(std::move(decoded.equirect));
    made.repairs = decoded.repairs;
  });
}

void expect_equal(const Made& a, const Made& b) {
  EXPECT_EQ(a.error.message, b.error.message);
  EXPECT_EQ(a.error.code, b.error.code);
  EXPECT_EQ(a.error.pointer, b.error.pointer);
  EXPECT_EQ(a.error.detail, b.error.detail);
  EXPECT_EQ(a.repairs, b.repairs);
  EXPECT_EQ(a.remarks, b.remarks);
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].extent, b.images[i].extent);
    EXPECT_EQ(a.images[i].channels, b.images[i].channels);
    EXPECT_EQ(a.images[i].type, b.images[i].type);
    EXPECT_EQ(a.images[i].color_space, b.images[i].color_space);
    EXPECT_TRUE(a.images[i].pixels == b.images[i].pixels);
  }
}

// Both ways, each as a texture and as an environment. Returns how many of the two were decoded.
int expect_same(const Blob& file, const DecodeLimits& limits = {}) {
  const Made pixels = texture(in_process_decoder(), file, ColorSpace::kNonColor, limits);
  expect_equal(pixels, texture(process_decoder(), file, ColorSpace::kNonColor, limits));
  const Made map = environment(in_process_decoder(), file, limits);
  expect_equal(map, environment(process_decoder(), file, limits));
  return int(!pixels.images.empty()) + int(!map.images.empty());
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
    EXPECT_EQ(expect_same(Blob(file), {.max_area_px = 3}), 0);  // told as kTooLarge, by name of the limit
  }
  EXPECT_EQ(expect_same(Blob()), 0);
}

// Every way through libraries that might start threads, or ask the system for something.
TEST(Decoders, AgreeOnLevelsAndRemarks) {
  const auto bytes = [](std::size_t size, std::uint32_t seed) {
    const std::vector<std::uint8_t> noise = sample::noise(size, seed);
    return std::string(noise.begin(), noise.end());
  };
  sample::Ktx2Parts chain;
  chain.width = 64;
  chain.height = 16;
  chain.level_count = 7;
  chain.transfer = 2;
  chain.flags = 1;
  for (int level = 0; level < 7; ++level)
    chain.levels.push_back(bytes(4u * (64u >> level) * std::max(16u >> level, 1u), unsigned(level)));
  sample::Ktx2Parts packed = chain;
  packed.scheme = 2;
  for (std::string& level : packed.levels) {
    std::string stored(ZSTD_compressBound(level.size()), '\0');
    stored.resize(ZSTD_compress(stored.data(), stored.size(), level.data(), level.size(), 3));
    level = stored;
  }
  const std::string avif = sample::lossless_avif(300, 200, 4, 8, sample::noise(300 * 200 * 4, 9));
  const std::string photograph = sample::subsampled_avif(201, 99, 4, sample::noise(201 * 99 * 4, 9));
  const std::string deep = sample::lossless_avif(64, 64, 3, 10, std::vector<std::uint8_t>(64 * 64 * 6, 1));
  for (const std::string& file : {sample::ktx2(chain), sample::ktx2(packed), avif, photograph, deep}) {
    for (const int side : {16384, 64, 33, 16, 1}) {
      // The wire takes no more than the limits: here the whole chain of the largest picture, or what was scaled down.
      EXPECT_EQ(expect_same(Blob(file), {side, 300 * 200}), 1);
    }
    EXPECT_EQ(expect_same(Blob(file), {16384, 64}), 0);
    EXPECT_EQ(expect_same(Blob(file.substr(0, file.size() / 2))), 0);
  }
  const Made whole = texture(process_decoder(), Blob(sample::ktx2(chain)), ColorSpace::kNonColor, {64, 1024});
  EXPECT_EQ(whole.images.size(), 7u);
  EXPECT_EQ(whole.remarks.size(), 2u);
  const Made scaled = texture(process_decoder(), Blob(avif), ColorSpace::kNonColor, {150, 300 * 200});
  ASSERT_EQ(scaled.images.size(), 1u);
  EXPECT_EQ(scaled.images[0].extent, (Extent{150, 100}));
  EXPECT_EQ(scaled.remarks.size(), 1u);
}

// A chain of one row is twice as long as its first level.
TEST(Decoders, AThinChainFitsItsBlock) {
  sample::Ktx2Parts line;
  line.vk_format = 91;  // R16G16B16A16_UNORM
  line.width = 128;
  line.level_count = 8;
  for (int level = 0; level < 8; ++level) line.levels.push_back(std::string(8u * (128u >> level), 'x'));
  EXPECT_EQ(expect_same(Blob(sample::ktx2(line)), {128, 128}), 1);
}

TEST(Decoders, AgreeOnColorSpaceAndRepairs) {
  const Blob png(encode_png(noise({4, 4}, 3, SampleType::kUint8, ColorSpace::kSrgb), {}));
  const DecodedTexture image = process_decoder().texture(png, ColorSpace::kSrgb, {}, Deadline());
  EXPECT_EQ(image.levels.at(0).color_space, ColorSpace::kSrgb);
  Image dirty = ramp({8, 4});
  dirty.samples<float>()[7] = -3;
  const DecodedEnvironment map = process_decoder().environment(
      Blob(encode_exr(dirty, {})), EnvironmentLayout::kAuto, DecodeLimits{}, Deadline());
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
