// ETC1S pictures written by the tests, against their texels by the formula.
#include "tests/image/etc1s_files.hpp"
#include "tests/support/hex.hpp"
#include "renderer/image/decode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

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

// 5 by 7 texels of grey and alpha as Basis Universal 1.16 wrote them, with the texels of its own transcoder.
TEST(Etc1s, ReadsTheReferenceEncodersFile) {
  const std::vector<std::uint8_t> file = test::bytes_of_hex(
      "ab4b5458203230bb0d0a1a0a000000000100000005000000070000000000000000000000010000000100000001000000"
      "680000003c000000a400000024000000c8000000000000009c0000000000000064010000000000000500000000000000"
      "00000000000000003c0000000000000002003800a301020003030000000000000000000000003f000000000000000000"
      "ffffffff40003f0f0000000000000000ffffffff1f0000004b545877726974657200426173697320556e697665727361"
      "6c20312e31360000050006002d000000190000002e000000000000000000000000000000030000000300000002000000"
      "15c084000100000000920f22808900000000000064410430110000000000802c300026000400000080a0d88107dcd8d8"
      "d800a8aa52050045c7a7242727af52fdff575555550500c14400000000000092eabf0201300140000000000239274084"
      "8401000040d8a84b210098000000000000400001331505c638");
  const std::vector<std::uint8_t> texels = test::bytes_of_hex(
      "000000ff000000cd0000009d0000006500000033000000ff000000cd0202029d0202026506060633"
      "000000ff020202cd0202029d0808086506060633000000ff020202cd0808089d080808650a0a0a33"
      "000000ff060606cd0606069d0a0a0a650e0e0e33000000ff060606cd0a0a0a9d1010106512121233"
      "000000ff060606cd0a0a0a9d1010106518181833");
  const DecodedTexture texture = decode_texture(std::as_bytes(std::span(file)), ColorSpace::kSrgb, {});
  ASSERT_EQ(texture.levels.size(), 1u);
  EXPECT_EQ(texture.levels[0].extent, (Extent{5, 7}));
  EXPECT_THAT(texture.levels[0].samples<std::uint8_t>(), testing::ElementsAreArray(texels));
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
