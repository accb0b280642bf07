#include "tests/image/sample_files.hpp"
#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"

#include <gtest/gtest.h>
#include <webp/mux.h>

#include <memory>

namespace furnace {
namespace {

TEST(WebpDecode, ReadsLosslessPixelsExactly) {
  for (int channels : {3, 4}) {
    auto samples = sample::noise(31u * 17u * static_cast<std::size_t>(channels), 3);
    // WebP drops the colour of invisible pixels.
    for (std::size_t i = 3; channels == 4 && i < samples.size(); i += 4) samples[i] |= 1;
    const Image image = sample::picture(sample::lossless_webp(31, 17, channels, samples), ColorSpace::kSrgb);
    ASSERT_EQ(image.extent, (Extent{31, 17}));
    ASSERT_EQ(image.channels, channels);
    EXPECT_TRUE(std::ranges::equal(image.samples<std::uint8_t>(), samples));
  }
}

TEST(WebpDecode, ChecksLimitsFirst) {
  const Blob file(sample::lossless_webp(20, 10, 3, std::vector<std::uint8_t>(600)));
  EXPECT_EQ(sample::error_of([&] { decode_texture(file, ColorSpace::kSrgb, {.max_area_px = 199}); }).code,
            ErrorCode::kTooLarge);
}

// A picture with flat areas, edges and a ramp; colour everywhere, for what is invisible may lose it.
Image rendered_like(int channels) {
  Image image = make_image({61, 43}, channels, SampleType::kUint8, ColorSpace::kSrgb);
  std::size_t at = 0;
  for (int y = 0; y < 43; ++y) {
    for (int x = 0; x < 61; ++x) {
      const bool inside = (x - 30) * (x - 30) + (y - 20) * (y - 20) < 200;
      const int pixel[] = {inside ? 200 : 4 * x, inside ? 30 + y : 3 * y, inside ? 60 : 128,
                           inside ? 255 : 1 + 2 * x};
      for (int c = 0; c < channels; ++c)
        image.samples<std::uint8_t>()[at++] = static_cast<std::uint8_t>(pixel[c]);
    }
  }
  return image;
}

// What encode_webp writes, as libwebp reads it.
TEST(WebpEncode, LosslessIsExact) {
  for (const int channels : {3, 4}) {
    const Image image = rendered_like(channels);
    const std::string file = encode_webp(image, {.lossless = true}, {});
    const Image back = sample::picture(file, ColorSpace::kSrgb);
    ASSERT_EQ(back.channels, channels);
    EXPECT_EQ(back.pixels, image.pixels);
    EXPECT_EQ(encode_webp(image, {.lossless = true}, {}), file);
  }
}

TEST(WebpEncode, QualityIsSizeAndAlphaStaysExact) {
  const Image image = rendered_like(4);
  const auto squared_error = [&](const std::string& file) {
    const Image back = sample::picture(file, ColorSpace::kSrgb);
    double sum = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const double difference =
          double(back.samples<std::uint8_t>()[i]) - double(image.samples<std::uint8_t>()[i]);
      if (i % 4 == 3) {
        EXPECT_EQ(difference, 0);
      }
      sum += difference * difference;
    }
    return sum / double(image.pixels.size());
  };
  const std::string coarse = encode_webp(image, {.quality = 20}, {}),
                    fine = encode_webp(image, {.quality = 95}, {});
  EXPECT_LT(coarse.size(), fine.size());
  EXPECT_LT(squared_error(fine), squared_error(coarse));
  EXPECT_LT(squared_error(fine), 100);  // 10 of 255: halved chroma at this picture's many edges
}

TEST(WebpEncode, MetadataIsXmp) {
  const std::string file =
      encode_webp(rendered_like(3), {}, {{"Software", "F 1"}, {"furnace:request", "a<\"&b"}});
  const WebPData data{reinterpret_cast<const std::uint8_t*>(file.data()), file.size()};
  const std::unique_ptr<WebPMux, decltype(&WebPMuxDelete)> mux(WebPMuxCreate(&data, 0), WebPMuxDelete);
  ASSERT_TRUE(mux);
  WebPData xmp;
  ASSERT_EQ(WebPMuxGetChunk(mux.get(), "XMP ", &xmp), WEBP_MUX_OK);
  const std::string_view text(reinterpret_cast<const char*>(xmp.bytes), xmp.size);
  EXPECT_NE(text.find("xmp:CreatorTool=\"F 1\""), std::string_view::npos) << text;
  EXPECT_NE(text.find("furnace:request=\"a&lt;&quot;&amp;b\""), std::string_view::npos) << text;
}

TEST(WebpEncodeDeathTest, RefusesOtherSampleTypes) {
  EXPECT_DEATH(encode_webp(make_image({1, 1}, 3, SampleType::kUint16, ColorSpace::kSrgb), {}, {}),
               "sample type");
}

}  // namespace
}  // namespace furnace
