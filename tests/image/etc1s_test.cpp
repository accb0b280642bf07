// ETC1S pictures written by the tests, against their texels by the formula.
#include "tests/image/etc1s_files.hpp"
#include "renderer/image/decode.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace furnace {
namespace {

using sample::etc1s_file;

TEST(Etc1s, TexelsAreThoseOfTheCodebooks) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Extent extent{seed % 2 ? 90 : 37, seed % 3 ? 61 : 128};
    std::vector<std::uint8_t> rgb, second;
    const Image image = sample::picture(etc1s_file(seed, extent, rgb, second), ColorSpace::kSrgb);
    ASSERT_EQ(image.extent, extent);
    ASSERT_EQ(image.channels, 4);
    const auto samples = image.samples<std::uint8_t>();
    for (std::size_t i = 0; i < rgb.size() / 3; ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_EQ(samples[i * 4 + c], rgb[i * 3 + c]) << seed << " texel " << i;
      ASSERT_EQ(samples[i * 4 + 3], second[i * 3 + 1]) << seed << " texel " << i;
    }
  }
}

TEST(Etc1s, DamageEndsInAPictureOrAnError) {
  std::vector<std::uint8_t> rgb, second;
  const std::string file = etc1s_file(3, {40, 40}, rgb, second);
  const auto decode = [](const std::string& bytes) {
    return sample::error_of([&] { decode_texture(Blob(bytes), ColorSpace::kSrgb, {16384, 1 << 20}); });
  };
  for (std::size_t size = 12; size < file.size(); size += 3) {
    const Error error = decode(file.substr(0, size));
    EXPECT_TRUE(error.code == ErrorCode::kUnprocessable) << size << error.message;
  }
  std::mt19937 random(9);
  for (int round = 0; round < 3000; ++round) {
    std::string broken = file;
    for (unsigned n = 1 + sample::next(random, 3); n > 0; --n) {
      const std::uint32_t at = 12 + sample::next(random, std::uint32_t(file.size() - 12));
      broken[at] = char(broken[at] ^ 1 << sample::next(random, 8));
    }
    const Error error = decode(broken);
    EXPECT_TRUE(error.message == "(nothing was thrown)" || error.code == ErrorCode::kUnprocessable ||
                error.code == ErrorCode::kTooLarge || error.code == ErrorCode::kUnsupportedMedia)
        << error.message;
  }
}

// Each level of a real file is much like the one above it made smaller: every block of both is where it should be.
TEST(Etc1s, ARealFilesLevelsAreAlike) {
  const std::filesystem::path path = "../shared/data/models/jet-fighter.glb";
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << "needs the test data in " << std::filesystem::absolute(path);
  std::ifstream stream(path, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  const std::string glb = text.str();
  const std::size_t start = glb.find("\xabKTX 20\xbb");
  ASSERT_NE(start, std::string::npos);
  const DecodedTexture texture =
      decode_texture(Blob(glb.substr(start, 1557676)), ColorSpace::kSrgb, {.max_side_px = 512});
  ASSERT_EQ(texture.levels.size(), 10u);
  for (std::size_t i = 0; i + 1 < texture.levels.size(); ++i) {
    const Image& large = texture.levels[i];
    const Image& small = texture.levels[i + 1];
    double error = 0;
    for (int y = 0; y < small.extent.height; ++y) {
      for (int x = 0; x < small.extent.width * 4; ++x) {
        const auto at = [&](int dx, int dy) {
          return int(large.samples<std::uint8_t>()[std::size_t(
              ((2 * y + dy) * large.extent.width + 2 * (x / 4) + dx) * 4 + x % 4)]);
        };
        const double mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0;
        const double difference =
            mean - small.samples<std::uint8_t>()[std::size_t(y * small.extent.width * 4 + x)];
        error += difference * difference;
      }
    }
    EXPECT_LT(error / double(small.extent.area() * 4), 255.0 * 255 / 100) << i;  // 20 dB
  }
}

}  // namespace
}  // namespace furnace
