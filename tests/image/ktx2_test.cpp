// The KTX2 container and its plain formats; UASTC's and ETC1S' texels have tests of their own.
#include "tests/image/ktx2_files.hpp"
#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libdeflate.h>
#include <zstd.h>

#include <algorithm>

namespace furnace {
namespace {

using sample::Ktx2Parts;

std::string text_of(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

std::vector<int> samples_of(const Image& image) {
  const auto samples = image.samples<std::uint8_t>();
  return {samples.begin(), samples.end()};
}

Image decoded(const Ktx2Parts& parts) {
  return sample::picture(sample::ktx2(parts), ColorSpace::kNonColor);
}

Error error_with(const Ktx2Parts& parts, const DecodeLimits& limits = {}) {
  return sample::error_of([&] { decode_texture(Blob(sample::ktx2(parts)), ColorSpace::kNonColor, limits); });
}

// Two texels of RGBA.
Ktx2Parts pair() {
  Ktx2Parts parts;
  parts.width = 2;
  parts.levels = {text_of({1, 2, 3, 4, 5, 6, 7, 8})};
  return parts;
}

TEST(Ktx2, ReadsEveryPlainFormat) {
  struct Row {
    std::uint32_t vk_format;
    std::vector<std::uint8_t> stored;
    std::vector<int> rgba;
  };
  for (const Row& row : {Row{9, {7}, {7, 0, 0, 255}}, Row{16, {7, 8}, {7, 8, 0, 255}},
                         Row{23, {7, 8, 9}, {7, 8, 9, 255}}, Row{29, {7, 8, 9}, {7, 8, 9, 255}},
                         Row{30, {7, 8, 9}, {9, 8, 7, 255}}, Row{37, {7, 8, 9, 10}, {7, 8, 9, 10}},
                         Row{43, {7, 8, 9, 10}, {7, 8, 9, 10}}, Row{44, {7, 8, 9, 10}, {9, 8, 7, 10}}}) {
    Ktx2Parts parts;
    parts.vk_format = row.vk_format;
    parts.levels = {text_of(row.stored)};
    EXPECT_EQ(samples_of(decoded(parts)), row.rgba) << row.vk_format;
  }
  Ktx2Parts deep;
  deep.vk_format = 77;  // R16G16_UNORM
  deep.levels = {text_of({0x34, 0x12, 0xcd, 0xab})};
  const Image image = decoded(deep);
  ASSERT_EQ(image.type, SampleType::kUint16);
  EXPECT_THAT(image.samples<std::uint16_t>(), testing::ElementsAre(0x1234, 0xabcd, 0, 0xffff));
}

TEST(Ktx2, UndoesSupercompression) {
  const std::vector<std::uint8_t> texels = sample::noise(64 * 64 * 4, 4);
  Ktx2Parts parts;
  parts.width = parts.height = 64;
  std::string zstd(ZSTD_compressBound(texels.size()), '\0');
  zstd.resize(ZSTD_compress(zstd.data(), zstd.size(), texels.data(), texels.size(), 3));
  libdeflate_compressor* compressor = libdeflate_alloc_compressor(6);
  std::string zlib(libdeflate_zlib_compress_bound(compressor, texels.size()), '\0');
  zlib.resize(libdeflate_zlib_compress(compressor, texels.data(), texels.size(), zlib.data(), zlib.size()));
  libdeflate_free_compressor(compressor);
  for (const auto& [scheme, level] :
       {std::pair(0u, text_of(texels)), std::pair(2u, zstd), std::pair(3u, zlib)}) {
    parts.scheme = scheme;
    parts.levels = {level};
    const Image image = decoded(parts);
    EXPECT_TRUE(std::ranges::equal(image.samples<std::uint8_t>(), texels)) << scheme;
    // More or fewer texels than the data have: whatever the file claims, never more than the extent's.
    for (const std::uint32_t height : {63u, 65u}) {
      parts.height = height;
      const bool longer = scheme == 0 && height == 63;  // padding is allowed where nothing is compressed
      EXPECT_EQ(error_with(parts).message == "(nothing was thrown)", longer) << scheme << " " << height;
    }
    parts.height = 64;
  }
}

TEST(Ktx2, KeepsItsLevels) {
  Ktx2Parts parts;
  parts.width = 5, parts.height = 2;
  parts.level_count = 3;
  for (const std::size_t texels : {10, 2, 1}) parts.levels.push_back(std::string(texels * 4, char(texels)));
  const DecodedTexture texture = decode_texture(Blob(sample::ktx2(parts)), ColorSpace::kNonColor, {});
  ASSERT_EQ(texture.levels.size(), 3u);
  EXPECT_EQ(texture.levels[1].extent, (Extent{2, 1}));
  EXPECT_EQ(texture.levels[2].extent, (Extent{1, 1}));
  EXPECT_THAT(samples_of(texture.levels[1]), testing::Each(2));
  EXPECT_TRUE(texture.remarks.empty());
}

TEST(Ktx2, TakesASmallerLevelWhereTheLargestIsTooLong) {
  Ktx2Parts parts;
  parts.width = parts.height = 4;
  parts.level_count = 3;
  for (const std::size_t texels : {16, 4, 1}) parts.levels.push_back(std::string(texels * 4, char(texels)));
  const auto largest = [&](int side) {
    const DecodedTexture texture =
        decode_texture(Blob(sample::ktx2(parts)), ColorSpace::kNonColor, {.max_side_px = side});
    EXPECT_EQ(texture.remarks.size(), side < 4 ? 1u : 0u);
    return texture.levels[0].extent;
  };
  EXPECT_EQ(largest(4), (Extent{4, 4}));
  EXPECT_EQ(largest(3), (Extent{2, 2}));
  parts.level_count = 1;
  parts.levels.resize(1);
  EXPECT_EQ(largest(3), (Extent{3, 3}));
}

TEST(Ktx2, HonoursSwizzleAndOrientation) {
  Ktx2Parts parts = pair();
  parts.metadata = {{"KTXwriter", "test"}, {"KTXswizzle", "bgr1"}};
  EXPECT_EQ(samples_of(decoded(parts)), (std::vector<int>{3, 2, 1, 255, 7, 6, 5, 255}));
  parts.metadata = {{"KTXswizzle", "rr0a"}, {"KTXorientation", "ld"}};
  EXPECT_EQ(samples_of(decoded(parts)), (std::vector<int>{5, 5, 0, 8, 1, 1, 0, 4}));
  parts.width = 1, parts.height = 2;
  parts.metadata = {{"KTXorientation", "ru"}};
  EXPECT_EQ(samples_of(decoded(parts)), (std::vector<int>{5, 6, 7, 8, 1, 2, 3, 4}));
  parts.metadata = {{"KTXswizzle", "rgbx"}};
  EXPECT_EQ(error_with(parts).code, ErrorCode::kUnprocessable);
}

TEST(Ktx2, TheUseSaysTheColourSpace) {
  const auto codes = [](std::uint8_t transfer, ColorSpace space, std::uint8_t flags = 0) {
    Ktx2Parts parts = pair();
    parts.transfer = transfer;
    parts.flags = flags;
    const DecodedTexture texture = decode_texture(Blob(sample::ktx2(parts)), space, {});
    EXPECT_EQ(texture.levels[0].color_space, space);
    std::string codes;
    for (const TextureRemark& remark : texture.remarks) codes += remark.code + " ";
    return codes;
  };
  EXPECT_EQ(codes(kDfTransferSrgb, ColorSpace::kSrgb), "");
  EXPECT_EQ(codes(kDfTransferLinear, ColorSpace::kNonColor), "");
  EXPECT_EQ(codes(0, ColorSpace::kSrgb), "");
  EXPECT_EQ(codes(kDfTransferLinear, ColorSpace::kSrgb), "texture-color-space ");
  EXPECT_EQ(codes(kDfTransferSrgb, ColorSpace::kNonColor), "texture-color-space ");
  EXPECT_EQ(codes(kDfTransferSrgb, ColorSpace::kSrgb, 1), "texture-premultiplied ");
}

TEST(Ktx2, ToldApartAreWhatIsNotReadAndWhatIsBroken) {
  const auto code_with = [](auto change) {
    Ktx2Parts parts = pair();
    change(parts);
    const std::string file = sample::ktx2(parts);
    const ErrorCode code = error_with(parts).code;
    EXPECT_EQ(texture_refusal(std::as_bytes(std::span(file))).has_value(),
              code == ErrorCode::kUnsupportedMedia);
    return code;
  };
  constexpr ErrorCode kNotRead = ErrorCode::kUnsupportedMedia, kBroken = ErrorCode::kUnprocessable;
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.depth = 1; }), kNotRead);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.layers = 1; }), kNotRead);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.faces = 6; }), kNotRead);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.height = 0; }), kNotRead);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.scheme = 4; }), kNotRead);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.vk_format = 145; }), kNotRead);  // BC7
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.vk_format = 0; }), kNotRead);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.level_count = 3; }), kBroken);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.channels.clear(); }), kBroken);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.levels[0].pop_back(); }), kBroken);
  EXPECT_EQ(code_with([](Ktx2Parts& parts) { parts.width = 70000; }), ErrorCode::kTooLarge);
  EXPECT_EQ(error_with(pair(), {.max_area_px = 1}).code, ErrorCode::kTooLarge);
}

TEST(Ktx2, DamageEndsInAPictureOrAnError) {
  Ktx2Parts parts;
  parts.vk_format = 0;
  parts.width = 13, parts.height = 9;
  parts.model = kDfModelUastc;
  parts.channels = {3};
  parts.scheme = 2;
  parts.metadata = {{"KTXswizzle", "bgra"}, {"KTXorientation", "rd"}};
  const std::vector<std::uint8_t> blocks(4 * 3 * 16, 0x17);  // solid
  std::string zstd(ZSTD_compressBound(blocks.size()), '\0');
  zstd.resize(ZSTD_compress(zstd.data(), zstd.size(), blocks.data(), blocks.size(), 3));
  parts.levels = {zstd};
  const std::string file = sample::ktx2(parts);
  ASSERT_NO_THROW(decode_texture(Blob(file), ColorSpace::kSrgb, {}));
  const auto expect_verdict = [](const std::string& bytes) {
    const Error error = sample::error_of([&] {
      decode_texture(Blob(bytes), ColorSpace::kSrgb, {16384, 1 << 20});
    });
    EXPECT_TRUE(error.message == "(nothing was thrown)" || error.code == ErrorCode::kUnprocessable ||
                error.code == ErrorCode::kTooLarge || error.code == ErrorCode::kUnsupportedMedia)
        << error.message;
  };
  for (std::size_t size = 0; size < file.size(); ++size) expect_verdict(file.substr(0, size));
  std::mt19937 random(6);
  for (int round = 0; round < 5000; ++round) {
    std::string broken = file;
    for (unsigned n = 1 + sample::next(random, 3); n > 0; --n) {
      const std::uint32_t at = sample::next(random, std::uint32_t(file.size()));
      broken[at] = sample::next(random, 4) == 0 ? '\xff' : char(broken[at] ^ 1 << sample::next(random, 8));
    }
    expect_verdict(broken);
  }
}

}  // namespace
}  // namespace furnace
