// Animated files, read by others: WebP by libwebpdemux, PNG chunk by chunk.
#include <memory>

#include <gmock/gmock.h>
#include <webp/demux.h>

#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"

namespace furnace {
namespace {

using ::testing::ElementsAre;

// A bright square that wanders over a gradient.
Image frame_image(int frame, int channels, SampleType type = SampleType::kUint8) {
  Image image = make_image({24, 16}, channels, type, ColorSpace::kSrgb);
  const auto fill = [&](auto samples, int most) {
    std::size_t i = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 24; ++x)
        for (int c = 0; c < channels; ++c) {
          const bool inside = std::abs(x - 4 * frame - 4) < 3 && std::abs(y - 8) < 3;
          const int value = c == 3 ? (inside ? most : most / 2) : inside ? most - 10 * c : most * x / 24;
          samples[i++] = static_cast<std::remove_reference_t<decltype(samples[0])>>(value);
        }
  };
  if (type == SampleType::kUint8)
    fill(image.samples<std::uint8_t>(), 255);
  else
    fill(image.samples<std::uint16_t>(), 65535);
  return image;
}

TEST(Animation, WebpHasEveryFrameAtItsTime) {
  for (const int channels : {3, 4}) {
    const auto encoder = webp_animation({4, 30, 2}, {.lossless = true}, {{"Software", "Furnace"}});
    for (int i = 0; i < 4; ++i) encoder->add(frame_image(i, channels));
    const std::string file = encoder->finish();
    EXPECT_NE(file.find("xmp:CreatorTool=\"Furnace\""), std::string::npos);
    EXPECT_NE(file.find("ICCP"), std::string::npos);

    WebPAnimDecoderOptions options;
    ASSERT_TRUE(WebPAnimDecoderOptionsInit(&options));
    const WebPData data{reinterpret_cast<const std::uint8_t*>(file.data()), file.size()};
    const std::unique_ptr<WebPAnimDecoder, decltype(&WebPAnimDecoderDelete)> decoder(
        WebPAnimDecoderNew(&data, &options), WebPAnimDecoderDelete);
    ASSERT_TRUE(decoder);
    WebPAnimInfo info;
    ASSERT_TRUE(WebPAnimDecoderGetInfo(decoder.get(), &info));
    EXPECT_EQ(info.loop_count, 2u);
    ASSERT_EQ(info.frame_count, 4u);
    std::vector<int> ends_ms;
    for (int i = 0; i < 4; ++i) {
      std::uint8_t* rgba = nullptr;
      int end_ms = 0;
      ASSERT_TRUE(WebPAnimDecoderGetNext(decoder.get(), &rgba, &end_ms));
      ends_ms.push_back(end_ms);
      const Image expected = frame_image(i, channels);
      for (std::size_t px = 0; px < 24 * 16; ++px)
        for (int c = 0; c < channels; ++c)
          ASSERT_EQ(rgba[px * 4 + std::size_t(c)],
                    expected.samples<std::uint8_t>()[px * std::size_t(channels) + std::size_t(c)])
              << "frame " << i << " pixel " << px;
    }
    EXPECT_THAT(ends_ms, ElementsAre(33, 67, 100, 133));
  }
}

std::uint32_t number_at(std::string_view file, std::size_t at, int bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8 | static_cast<std::uint8_t>(file[at + std::size_t(i)]);
  return value;
}

struct PngChunk {
  std::string type;
  std::size_t content = 0, size = 0;
};

std::vector<PngChunk> chunks_of(std::string_view file) {
  std::vector<PngChunk> chunks;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t size = number_at(file, at, 4);
    chunks.push_back({std::string(file.substr(at + 4, 4)), at + 8, size});
    at += size + 12;
  }
  return chunks;
}

// The compressor is deterministic: a frame's rows are those of a still of it.
std::string_view rows_of_still(const std::string& still) {
  for (const PngChunk& chunk : chunks_of(still))
    if (chunk.type == "IDAT") return std::string_view(still).substr(chunk.content, chunk.size);
  return {};
}

TEST(Animation, PngHasEveryFrameInOrder) {
  for (const SampleType type : {SampleType::kUint8, SampleType::kUint16}) {
    const auto encoder = png_animation({3, 23.98, 0}, {{"Software", "Furnace"}});
    for (int i = 0; i < 3; ++i) encoder->add(frame_image(i, 4, type));
    const std::string file = encoder->finish();

    std::vector<std::string> types;
    std::uint32_t sequence = 0;
    int frame = 0;
    for (const PngChunk& chunk : chunks_of(file)) {
      types.push_back(chunk.type);
      if (chunk.type == "acTL") {
        EXPECT_EQ(number_at(file, chunk.content, 4), 3u);
        EXPECT_EQ(number_at(file, chunk.content + 4, 4), 0u);
      }
      if (chunk.type == "fcTL" || chunk.type == "fdAT") {
        EXPECT_EQ(number_at(file, chunk.content, 4), sequence++);
      }
      if (chunk.type == "fcTL") {
        EXPECT_EQ(chunk.size, 26u);
        EXPECT_EQ(number_at(file, chunk.content + 4, 4), 24u);
        EXPECT_EQ(number_at(file, chunk.content + 8, 4), 16u);
        EXPECT_EQ(number_at(file, chunk.content + 20, 2), 100u);
        EXPECT_EQ(number_at(file, chunk.content + 22, 2), 2398u);
      }
      if (chunk.type == "IDAT" || chunk.type == "fdAT") {
        const std::size_t skip = chunk.type == "fdAT" ? 4 : 0;
        const std::string still = encode_png(frame_image(frame++, 4, type), {});
        EXPECT_EQ(file.substr(chunk.content + skip, chunk.size - skip), rows_of_still(still));
      }
    }
    EXPECT_THAT(types, ElementsAre("IHDR", "sRGB", "gAMA", "cHRM", "tEXt", "acTL", "fcTL", "IDAT", "fcTL",
                                   "fdAT", "fcTL", "fdAT", "IEND"));
    // Readers that know no animation see the first frame; ours checks every checksum.
    const Image first =
        decode_texture(std::as_bytes(std::span(file)), ColorSpace::kSrgb, DecodeLimits{}).levels.front();
    const Image expected = frame_image(0, 4, type);
    ASSERT_EQ(first.type, type);
    EXPECT_EQ(first.pixels, expected.pixels);
  }
}

}  // namespace
}  // namespace furnace
