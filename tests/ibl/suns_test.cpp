#include "renderer/ibl/suns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/base/file.hpp"
#include "renderer/image/decode.hpp"
#include "tests/support/reference/convolution.hpp"

namespace furnace {
namespace {

using reference::Direction;
using reference::Rgb;

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;
constexpr Extent kExtent = {512, 256};

Image constant_map(const Rgb& value, Extent extent = kExtent) {
  Image map = make_image(extent, 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (std::size_t k = 0; k < map.samples<float>().size(); ++k)
    map.samples<float>()[k] = static_cast<float>(value[k % 3]);
  return map;
}

double angle_between(const Rgb& a, const Rgb& b) {
  return 2 * std::asin(std::min(1.0, 0.5 * std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2])));
}

// Adds `value` where inside(direction) holds, as a camera would: the mean of 8 x 8 points of equal area in each texel.
template <class Inside>
void paint(Image& map, const Rgb& value, Inside&& inside) {
  constexpr int kParts = 8;
  const auto [width, height] = map.extent;
  for (int j = 0; j < height; ++j) {
    const auto height_at = [&](int row) { return std::pow(std::sin(kPi * row / (2 * height)), 2); };
    std::array<double, kParts> theta;
    for (int k = 0; k < kParts; ++k)
      theta[k] = 2 * std::asin(std::sqrt(std::lerp(height_at(j), height_at(j + 1), (k + 0.5) / kParts)));
    for (int i = 0; i < width; ++i) {
      int hits = 0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const double column = i + (part % kParts + 0.5) / kParts;
        hits += inside(Direction{theta[part / kParts], 2 * kPi * (column / width - 0.5)}) ? 1 : 0;
      }
      float* out = map.samples<float>().data() + (std::size_t(j) * width + i) * 3;
      for (int c = 0; c < 3; ++c) out[c] += static_cast<float>(value[c] * hits / (kParts * kParts));
    }
  }
}

void paint_disc(Image& map, const Direction& centre, double radius_rad, const Rgb& value) {
  const Rgb axis = centre.unit();
  paint(map, value, [&](const Direction& d) {
    // Most points are far off in height already.
    return std::abs(d.theta - centre.theta) <= radius_rad && angle_between(d.unit(), axis) <= radius_rad;
  });
}

void expect_energy_kept(const Image& map, const SunExtraction& extraction) {
  const Rgb before = reference::mean_radiance(map), after = reference::mean_radiance(extraction.residual);
  for (int c = 0; c < 3; ++c) {
    double flux = 4 * kPi * after[c];
    for (const Sun& sun : extraction.suns) flux += sun.irradiance[c];
    // Double sums of up to 5e5 texels, and the reference takes a texel's area as a difference of cosines.
    EXPECT_NEAR(flux, 4 * kPi * before[c], 1e-9 * 4 * kPi * before[c]);
  }
  ASSERT_EQ(extraction.residual.pixels.size(), map.pixels.size());
  for (std::size_t k = 0; k < map.samples<float>().size(); ++k) {
    ASSERT_GE(extraction.residual.samples<float>()[k], 0);
    ASSERT_LE(extraction.residual.samples<float>()[k], map.samples<float>()[k]);
  }
}

// Where the suns of these tests stand: in mid sky, over the seam at u = 0, near and in the poles.
const Direction kPlaces[] = {{1.0, 0.4}, {1.3, kPi - 1e-4}, {1.3, -kPi + 0.003}, {0.004, 2.0},
                             {0.0, 0.0}, {kPi, 0.0},        {0.12, -2.5},        {kPi / 2, kPi / 2}};

TEST(Suns, DiscAnywhere) {
  for (const Direction& place : kPlaces) {
    SCOPED_TRACE(testing::Message() << place.theta << " " << place.phi);
    const double radius = 0.8 * kDegree;
    const Rgb value = {1.2e5, 1e5, 0.7e5};
    Image map = constant_map({1, 1.5, 2});
    paint_disc(map, place, radius, value);
    const SunExtraction extraction = extract_suns(map, {});
    ASSERT_EQ(extraction.suns.size(), 1u);
    const Sun& sun = extraction.suns[0];
    // 64 points in a texel of 0.7 degrees.
    EXPECT_LE(angle_between(sun.direction, place.unit()), 0.05 * kDegree);
    EXPECT_NEAR(std::hypot(sun.direction[0], sun.direction[1], sun.direction[2]), 1, 1e-12);
    const double area = 4 * kPi * std::pow(std::sin(radius / 2), 2);
    const Rgb mean = reference::mean_radiance(map);
    for (int c = 0; c < 3; ++c) {
      const double painted = 4 * kPi * (mean[c] - (1 + 0.5 * c));
      EXPECT_NEAR(painted / (value[c] * area), 1, 0.09);  // in the pole the points lie on few circles
      // Texels that the disc hardly touches are left in the map.
      EXPECT_NEAR(sun.irradiance[c] / painted, 1, 2e-3);
    }
    // The texels blur it: by their own second moment, 0.7^2 / 6 twice.
    EXPECT_NEAR(sun.angular_radius_rad / radius, 1, 0.3);
    EXPECT_GE(sun.angular_radius_rad, radius * 0.99);
    EXPECT_GE(sun.solid_angle_sr, 0.8 * area);
    EXPECT_FLOAT_EQ(static_cast<float>(sun.peak),
                    *std::max_element(map.samples<float>().begin(), map.samples<float>().end()));
    expect_energy_kept(map, extraction);
    // A flat sky closes without a trace, but for texels below a hundredth of the sun.
    for (float sample : extraction.residual.samples<float>()) EXPECT_LE(sample, 0.011 * value[0]);
  }
}

TEST(Suns, SkyClosesBehindASun) {
  Image map = constant_map({1, 1.5, 2});
  const std::size_t texel = (std::size_t(90) * kExtent.width + 511) * 3;
  for (int c = 0; c < 3; ++c) map.samples<float>()[texel + c] = 1e5f;
  const SunExtraction extraction = extract_suns(map, {});
  ASSERT_EQ(extraction.suns.size(), 1u);
  for (std::size_t k = 0; k < map.samples<float>().size(); ++k)
    ASSERT_NEAR(extraction.residual.samples<float>()[k], 1 + 0.5 * (k % 3), 1e-6);
  const Rgb expected = reference::texel_direction(kExtent, 511, 90).unit();
  EXPECT_LE(angle_between(extraction.suns[0].direction, expected), 1e-9);
  // A square of side s has the second moment of a disc of s / sqrt(3); this texel is narrower than high.
  EXPECT_NEAR(extraction.suns[0].angular_radius_rad / (kPi / 256 / std::sqrt(3)), 1, 0.1);
}

TEST(Suns, JoinOverThePole) {
  Image map = constant_map({1, 1, 1});
  for (const int column : {10, 10 + kExtent.width / 2}) map.samples<float>()[3 * column + 1] = 1e7f;
  const SunExtraction extraction = extract_suns(map, {});
  ASSERT_EQ(extraction.suns.size(), 1u);
  EXPECT_LE(angle_between(extraction.suns[0].direction, {0, 1, 0}), 1e-9);
  expect_energy_kept(map, extraction);
}

TEST(Suns, OrientationOfTheAxes) {
  const std::pair<std::pair<int, int>, Rgb> axes[] = {{{256, 128}, {1, 0, 0}},
                                                      {{384, 128}, {0, 0, 1}},
                                                      {{128, 128}, {0, 0, -1}},
                                                      {{0, 128}, {-1, 0, 0}},
                                                      {{77, 0}, {0, 1, 0}}};
  for (const auto& [texel, axis] : axes) {
    Image map = constant_map({0.1, 0.1, 0.1});
    map.samples<float>()[(texel.second * kExtent.width + texel.first) * 3 + 1] = 1e6f;
    const SunExtraction extraction = extract_suns(map, {});
    ASSERT_EQ(extraction.suns.size(), 1u);
    EXPECT_LE(angle_between(extraction.suns[0].direction, axis), 0.6 * kDegree);  // a texel's half diagonal
  }
}

TEST(Suns, TwoBrightestFirst) {
  Image map = constant_map({1, 1, 1});
  const Direction places[] = {{0.8, -2.0}, {1.2, 1.0}};
  paint_disc(map, places[0], 0.5 * kDegree, {4e4, 4e4, 4e4});
  paint_disc(map, places[1], 0.5 * kDegree, {1e5, 1e5, 1e5});
  const SunExtraction extraction = extract_suns(map, {});
  ASSERT_EQ(extraction.suns.size(), 2u);
  EXPECT_LE(angle_between(extraction.suns[0].direction, places[1].unit()), 0.05 * kDegree);
  EXPECT_LE(angle_between(extraction.suns[1].direction, places[0].unit()), 0.05 * kDegree);
  EXPECT_NEAR(extraction.suns[0].irradiance[1] / extraction.suns[1].irradiance[1], 2.5, 0.1);
  expect_energy_kept(map, extraction);

  SunSettings one;
  one.most = 1;
  const SunExtraction brightest = extract_suns(map, {}, one);
  ASSERT_EQ(brightest.suns.size(), 1u);
  EXPECT_LE(angle_between(brightest.suns[0].direction, places[1].unit()), 0.05 * kDegree);
  expect_energy_kept(map, brightest);
}

TEST(Suns, GlareStaysInTheMap) {
  Image map = constant_map({0, 0, 0});
  const Direction place = {0.9, 0.7};
  const auto glare = [&](const Direction& d) {  // 300 beside a sun of 1e5, gone after some degrees
    return 1 + 300 * std::exp(-angle_between(d.unit(), place.unit()) / (3 * kDegree));
  };
  for (int j = 0; j < kExtent.height; ++j)
    for (int i = 0; i < kExtent.width; ++i)
      for (int c = 0; c < 3; ++c)
        map.samples<float>()[(std::size_t(j) * kExtent.width + i) * 3 + c] =
            static_cast<float>(glare(reference::texel_direction(kExtent, i, j)));
  const Rgb without = reference::mean_radiance(map);
  paint_disc(map, place, 0.8 * kDegree, {1e5, 1e5, 1e5});
  const SunExtraction extraction = extract_suns(map, {});
  ASSERT_EQ(extraction.suns.size(), 1u);
  const double area = 4 * kPi * std::pow(std::sin(0.4 * kDegree), 2);
  EXPECT_NEAR(extraction.suns[0].irradiance[0] / (1e5 * area), 1, 0.03);
  EXPECT_LE(extraction.suns[0].angular_radius_rad, 1.2 * kDegree);
  EXPECT_NEAR(reference::mean_radiance(extraction.residual)[0] / without[0], 1, 0.05);
}

TEST(Suns, WhatIsNoSun) {
  const auto expect_none = [](const Image& map, const char* what) {
    const SunExtraction extraction = extract_suns(map, {});
    EXPECT_TRUE(extraction.suns.empty()) << what;
    EXPECT_EQ(extraction.residual.pixels, map.pixels) << what;
  };
  expect_none(constant_map({0, 0, 0}), "nothing");
  expect_none(constant_map({2, 1, 3}), "a constant");
  expect_none(constant_map({1e5, 1e5, 1e5}, {2, 1}), "two texels");

  Image box = constant_map({0.1, 0.1, 0.1});
  paint(box, {500, 500, 500}, [](const Direction& d) {
    return std::abs(d.theta - 1.2) < 7 * kDegree && std::abs(d.phi - 3) < 7 * kDegree;
  });
  expect_none(box, "a soft box");

  Image tube = constant_map({0.1, 0.1, 0.1});
  paint(tube, {5e4, 5e4, 5e4}, [](const Direction& d) {
    return std::abs(d.theta - 1.2) < 0.1 * kDegree && std::abs(d.phi) < 6 * kDegree;
  });
  expect_none(tube, "a tube");

  for (const double sigma : {1.5 * kDegree, 4 * kDegree}) {
    Image glow = constant_map({}, {1024, 512});
    for (int j = 0; j < 512; ++j) {
      for (int i = 0; i < 1024; ++i) {
        const double angle =
            angle_between(reference::texel_direction(glow.extent, i, j).unit(), Direction{0.6, 1}.unit());
        for (int c = 0; c < 3; ++c)
          glow.samples<float>()[(std::size_t(j) * 1024 + i) * 3 + c] =
              static_cast<float>(0.05 + 1e4 * std::exp(-0.5 * std::pow(angle / sigma, 2)));
      }
    }
    expect_none(glow, "an overcast sky's bright part");
  }

  Image faint = constant_map({1, 1, 1});
  paint_disc(faint, {1, 1}, 0.5 * kDegree, {2000, 2000, 2000});  // 4 % of the flux
  expect_none(faint, "a faint lamp");
}

TEST(Suns, NoiseHasNoneAndKeepsItsEnergy) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 3; ++trial) {
    Image map = constant_map({}, {256, 128});
    const double contrast = 4 + 4 * trial;  // up to 300, 2e4 and 9e5 times the least
    for (float& sample : map.samples<float>())
      sample = static_cast<float>(std::exp(contrast * std::pow(random() / 4294967296.0, 0.5)));
    const SunExtraction noise = extract_suns(map, {});
    EXPECT_TRUE(noise.suns.empty()) << trial;
    // With suns of any shape in it.
    for (int k = 0; k < 5; ++k)
      map.samples<float>()[random() % map.samples<float>().size()] =
          static_cast<float>(std::exp(contrast) * 1e4 * (k + 1));
    const SunExtraction extraction = extract_suns(map, {});
    EXPECT_FALSE(extraction.suns.empty()) << trial;
    EXPECT_EQ(find_suns(map, {}), extraction.suns) << trial;
    expect_energy_kept(map, extraction);
  }
}

TEST(Suns, StopAtTheDeadline) {
  EXPECT_THROW(find_suns(constant_map({1, 1, 1}), Deadline(std::chrono::milliseconds(0))), Error);
}

// How many suns a photographer would name.
TEST(Suns, RealEnvironments) {
  const std::filesystem::path folder = std::string(FURNACE_SOURCE_DIR) + "/../shared/data/environments";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "there is no " << folder;
  const std::pair<const char*, std::size_t> files[] = {
      {"KernerEnvLatLong.exr", 1},
      {"OrientationLatLong.exr", 0},
      {"blender_city.exr", 1},
      {"blender_night.exr", 2},
      {"blender_studio.exr", 0},
      {"blender_sunset.exr", 0},
      {"dikhololo_night_1k.hdr", 0},
      {"kloofendal_48d_partly_cloudy_1k.exr", 1},
      {"narrow_moonlit_road_1k.hdr", 1},
      {"noon_grass_1k.hdr", 1},
      {"pedestrian_overpass_1k.hdr", 1},
      {"pmndrs_sunrise_512.exr", 0},
      {"potsdamer_platz_1k.hdr", 0},
      {"royal_esplanade_256.hdr", 1},
      {"spiaggia_di_mondello_1k.hdr", 1},
      {"st_fagans_interior_1k.hdr", 0},
      {"studio_small_03_1k.hdr", 0},
      {"venice_sunset_1k.hdr", 0},
  };
  for (const auto& [name, suns] : files) {
    SCOPED_TRACE(name);
    if (!file_identity(folder / name)) continue;
    const Image map = decode_environment(Blob(read_file(folder / name, 1 << 24)), {}).equirect;
    const SunExtraction extraction = extract_suns(map, {});
    EXPECT_EQ(extraction.suns.size(), suns);
    EXPECT_EQ(find_suns(map, {}), extraction.suns);
    expect_energy_kept(map, extraction);
  }
}

}  // namespace
}  // namespace furnace
