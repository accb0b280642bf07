// The profile read tag by tag as ICC.1:2010 lays it out, and found in the files that carry it.
#include "renderer/image/srgb_profile.hpp"
#include "renderer/image/color.hpp"
#include "renderer/image/encode.hpp"

#include <gtest/gtest.h>
#include <webp/mux.h>

#include <cmath>
#include <memory>

namespace furnace {
namespace {

std::uint32_t u32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes.at(at + i));
  return value;
}

double fixed_at(std::string_view bytes, std::size_t at) {
  return static_cast<std::int32_t>(u32_at(bytes, at)) / 65536.0;
}

std::string_view tag(std::string_view profile, std::string_view name) {
  for (std::size_t i = 0; i < u32_at(profile, 128); ++i) {
    const std::size_t row = 132 + 12 * i;
    if (profile.substr(row, 4) == name)
      return profile.substr(u32_at(profile, row + 4), u32_at(profile, row + 8));
  }
  ADD_FAILURE() << "no tag " << name;
  return {};
}

TEST(SrgbProfile, HeaderIsThatOfADisplay) {
  const std::string profile = srgb_icc_profile();
  EXPECT_EQ(u32_at(profile, 0), profile.size());
  EXPECT_EQ(profile.substr(12, 12), "mntrRGB XYZ ");
  EXPECT_EQ(profile.substr(36, 4), "acsp");
  EXPECT_LT(profile.size(), 700u);  // every picture carries it
  for (const char* name : {"desc", "cprt", "wtpt", "chad", "rXYZ", "gXYZ", "bXYZ", "rTRC", "gTRC", "bTRC"})
    EXPECT_EQ((tag(profile, name).data() - profile.data()) % 4, 0) << name;
}

TEST(SrgbProfile, PrimariesAddUpToWhite) {
  const std::string profile = srgb_icc_profile();
  const auto component = [&](const char* name, std::size_t i) {
    return fixed_at(tag(profile, name), 8 + 4 * i);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const double sum = component("rXYZ", i) + component("gXYZ", i) + component("bXYZ", i);
    EXPECT_NEAR(sum, component("wtpt", i), 4e-4) << i;  // D50 of the table against that of profiles
    EXPECT_EQ(component("wtpt", i), fixed_at(profile, 68 + 4 * i));
  }
  // Luminances are those of Rec.709 but for the adaptation of white.
  EXPECT_NEAR(component("gXYZ", 1), 0.7152, 2e-3);
}

TEST(SrgbProfile, CurveIsTheTransferFunction) {
  const std::string profile = srgb_icc_profile();
  for (const char* name : {"rTRC", "gTRC", "bTRC"}) {
    const std::string_view curve = tag(profile, name);
    ASSERT_EQ(curve.substr(0, 4), "para");
    ASSERT_EQ(u32_at(curve, 8) >> 16, 3u);
    const auto p = [&](std::size_t i) { return fixed_at(curve, 12 + 4 * i); };
    for (int i = 0; i <= 255; ++i) {
      const double x = i / 255.0;
      const double linear = x >= p(4) ? std::pow(p(1) * x + p(2), p(0)) : p(3) * x;
      EXPECT_NEAR(linear, linear_from_srgb(x), 5e-5) << i;  // numbers of 16 bits
    }
  }
}

TEST(SrgbProfile, IsInJpegAndWebp) {
  const Image image = make_image({4, 4}, 3, SampleType::kUint8, ColorSpace::kSrgb);
  const std::string profile = srgb_icc_profile();
  EXPECT_NE(encode_jpeg(image, 90, {}).find(std::string("ICC_PROFILE\0\x01\x01", 14) + profile),
            std::string::npos);
  const std::string webp = encode_webp(image, {}, {});
  const WebPData data{reinterpret_cast<const std::uint8_t*>(webp.data()), webp.size()};
  const std::unique_ptr<WebPMux, decltype(&WebPMuxDelete)> mux(WebPMuxCreate(&data, 0), WebPMuxDelete);
  WebPData found;
  ASSERT_EQ(WebPMuxGetChunk(mux.get(), "ICCP", &found), WEBP_MUX_OK);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(found.bytes), found.size), profile);
}

}  // namespace
}  // namespace furnace
