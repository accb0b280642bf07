#include "renderer/image/environment_layout.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/image/decode.hpp"
#include "renderer/image/encode.hpp"
#include "tests/image/sample_files.hpp"

namespace furnace {
namespace {

using testing::HasSubstr;
using Direction = std::array<double, 3>;
using Rgb = std::array<double, 3>;
using RadianceOf = std::function<Rgb(const Direction&)>;

constexpr double kPi = std::numbers::pi;
constexpr EnvironmentLayout kCubes[] = {
    EnvironmentLayout::kHorizontalCross, EnvironmentLayout::kVerticalCross,
    EnvironmentLayout::kHorizontalStrip, EnvironmentLayout::kVerticalStrip};

// By faces: +X -X +Y -Y +Z -Z.
std::array<int, 2> place_of(EnvironmentLayout layout, int face) {
  constexpr int kHorizontal[6][2] = {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}};
  constexpr int kVertical[6][2] = {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}};
  switch (layout) {
    case EnvironmentLayout::kHorizontalCross:
      return {kHorizontal[face][0], kHorizontal[face][1]};
    case EnvironmentLayout::kVerticalCross:
      return {kVertical[face][0], kVertical[face][1]};
    case EnvironmentLayout::kHorizontalStrip:
      return {face, 0};
    default:
      return {0, face};
  }
}

Extent extent_of(EnvironmentLayout layout, int side) {
  switch (layout) {
    case EnvironmentLayout::kHorizontalCross:
      return {4 * side, 3 * side};
    case EnvironmentLayout::kVerticalCross:
      return {3 * side, 4 * side};
    case EnvironmentLayout::kHorizontalStrip:
      return {6 * side, side};
    default:
      return {side, 6 * side};
  }
}

// OpenGL 4.6, table 8.19.
Direction direction_of(int face, double a, double b) {
  const Direction all[6] = {{1, -b, -a}, {-1, -b, a}, {a, 1, b}, {a, -1, -b}, {a, -b, 1}, {-a, -b, -1}};
  const double length = std::sqrt(1 + a * a + b * b);
  return {all[face][0] / length, all[face][1] / length, all[face][2] / length};
}

float* texel_of(Image& picture, EnvironmentLayout layout, int side, int face, int i, int j) {
  if (layout == EnvironmentLayout::kVerticalCross && face == 5) i = side - 1 - i, j = side - 1 - j;
  const auto [column, row] = place_of(layout, face);
  return picture.samples<float>().data() +
         3 * (std::size_t(row * side + j) * picture.extent.width + column * side + i);
}

// What no face covers is so bright that nobody could miss it.
Image cube_of(EnvironmentLayout layout, int side, const RadianceOf& radiance) {
  Image picture = make_image(extent_of(layout, side), 3, SampleType::kFloat32, ColorSpace::kLinear);
  for (float& sample : picture.samples<float>()) sample = 1e20f;
  for (int face = 0; face < 6; ++face) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const Rgb value = radiance(direction_of(face, (2 * i + 1.0) / side - 1, (2 * j + 1.0) / side - 1));
        for (int c = 0; c < 3; ++c)
          texel_of(picture, layout, side, face, i, j)[c] = static_cast<float>(value[c]);
      }
    }
  }
  return picture;
}

Direction equirect_direction(const Extent& extent, int i, int j) {
  const double theta = kPi * (j + 0.5) / extent.height, phi = 2 * kPi * ((i + 0.5) / extent.width - 0.5);
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

const float* texel(const Image& equirect, int i, int j) {
  return equirect.samples<float>().data() + 3 * (std::size_t(j) * equirect.extent.width + i);
}

TEST(EnvironmentLayout, IsToldByTheAspect) {
  const auto told = [](int width, int height) { return layout_of(width, height, EnvironmentLayout::kAuto); };
  EXPECT_EQ(told(1024, 512), EnvironmentLayout::kEquirect);
  for (const EnvironmentLayout layout : kCubes) {
    const Extent extent = extent_of(layout, 37);
    EXPECT_EQ(told(extent.width, extent.height), layout);
    EXPECT_EQ(layout_of(extent.width, extent.height, layout), layout);
    EXPECT_EQ(layout_of(extent.width, extent.height, EnvironmentLayout::kEquirect), EnvironmentLayout::kAuto);
    EXPECT_EQ(face_side(extent, layout), 37);
  }
  EXPECT_EQ(told(512, 512), EnvironmentLayout::kAuto);
  EXPECT_EQ(told(401, 300), EnvironmentLayout::kAuto);
}

TEST(CubeEnvironment, AConstantStaysConstant) {
  for (const EnvironmentLayout layout : kCubes) {
    for (int side : {1, 2, 7, 16}) {
      const Image map = equirect_of_cube(cube_of(layout, side,
                                                 [](const Direction&) {
                                                   return Rgb{1, 2, 0.5};
                                                 }),
                                         layout);
      ASSERT_EQ(map.extent, (Extent{4 * side, 2 * side}));
      for (std::size_t k = 0; k < map.samples<float>().size(); ++k)
        ASSERT_NEAR(map.samples<float>()[k], (Rgb{1, 2, 0.5}[k % 3]), 1e-5) << name_of(layout) << " " << side;
    }
  }
}

// Every face in its place and the right way up, poles and edges too: radiance that grows along x, y and z.
TEST(CubeEnvironment, ShowsWhatOpenGlWouldLookUp) {
  const RadianceOf radiance = [](const Direction& d) { return Rgb{2 + d[0], 2 + d[1], 2 + d[2]}; };
  for (const EnvironmentLayout layout : kCubes) {
    for (int side : {15, 32}) {
      const Image map = equirect_of_cube(cube_of(layout, side, radiance), layout);
      for (int j = 0; j < map.extent.height; ++j) {
        for (int i = 0; i < map.extent.width; ++i) {
          const Rgb expected = radiance(equirect_direction(map.extent, i, j));
          // A texel in the middle of a face is 2 / side wide, and constant.
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(texel(map, i, j)[c], expected[c], 1.1 / side)
                << name_of(layout) << " " << i << " " << j;
        }
      }
    }
  }
}

// Solid angle of the part of a face from its middle to (a, b), signed: van Oosterom and Strackee 1983, "The solid angle of a
// plane triangle", for a rectangle.
double corner_sr(double a, double b) {
  return std::atan2(a * b, std::sqrt(1 + a * a + b * b));
}

TEST(CubeEnvironment, ALoneTexelKeepsItsEnergy) {
  constexpr int kSides[] = {9, 24};
  for (int side : kSides) {
    for (int face = 0; face < 6; ++face) {
      for (const auto& [i, j] :
           {std::array{0, 0}, {side / 2, side / 2}, {side - 1, side / 3}, {side / 3 + 1, 2}}) {
        const auto layout = EnvironmentLayout::kHorizontalCross;
        Image picture = cube_of(layout, side, [](const Direction&) { return Rgb{0, 0, 0}; });
        texel_of(picture, layout, side, face, i, j)[1] = 1e5f;
        const Image map = equirect_of_cube(picture, layout);
        double energy = 0;
        for (int row = 0; row < map.extent.height; ++row) {
          const double sr =
              2 * kPi / map.extent.width *
              (std::cos(kPi * row / map.extent.height) - std::cos(kPi * (row + 1) / map.extent.height));
          for (int column = 0; column < map.extent.width; ++column) energy += sr * texel(map, column, row)[1];
        }
        const double a0 = 2.0 * i / side - 1, a1 = a0 + 2.0 / side, b0 = 2.0 * j / side - 1,
                     b1 = b0 + 2.0 / side;
        const double expected =
            1e5 * (corner_sr(a1, b1) - corner_sr(a0, b1) - corner_sr(a1, b0) + corner_sr(a0, b0));
        EXPECT_NEAR(energy / expected, 1, 1e-3) << side << " face " << face << ": " << i << ", " << j;
      }
    }
  }
}

TEST(CubeEnvironment, IsDecodedAsItsLayoutSays) {
  const RadianceOf radiance = [](const Direction& d) { return Rgb{1, d[1] > 0 ? 2.0 : 1.0, 1}; };
  const Image cross = cube_of(EnvironmentLayout::kVerticalCross, 8, radiance);
  const Blob file(encode_exr(cross, {}));
  const DecodedEnvironment decoded = decode_environment(file, {});
  EXPECT_EQ(decoded.layout, EnvironmentLayout::kVerticalCross);
  EXPECT_EQ(decoded.equirect.extent, (Extent{32, 16}));
  EXPECT_EQ(decode_environment(file, {}, EnvironmentLayout::kVerticalCross).equirect.pixels,
            decoded.equirect.pixels);
  const Error other = sample::error_of([&] { decode_environment(file, {}, EnvironmentLayout::kEquirect); });
  EXPECT_EQ(other.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(other.message, HasSubstr("vertical-cross"));
}

// Programs leave there whatever they like; of it nothing is repaired, and nothing is told.
TEST(CubeEnvironment, WhatIsBesideTheFacesDoesNotCount) {
  for (const EnvironmentLayout layout :
       {EnvironmentLayout::kHorizontalCross, EnvironmentLayout::kVerticalCross}) {
    constexpr int kSide = 2;
    Image cross = cube_of(layout, kSide, [](const Direction& d) {
      return Rgb{2 + d[0], 2 + d[1], 2 + d[2]};
    });
    const DecodedEnvironment clean = decode_environment(Blob(encode_exr(cross, {})), {});
    const auto samples = cross.samples<float>();
    const std::size_t first_row = std::size_t(cross.extent.width) * 3;
    std::fill_n(samples.begin(), 3 * kSide, std::numeric_limits<float>::quiet_NaN());  // no face in any cross
    std::fill_n(samples.begin() + std::ptrdiff_t(first_row) - 3, 3, -1.0f);
    const DecodedEnvironment decoded = decode_environment(Blob(encode_exr(cross, {})), {});
    EXPECT_EQ(decoded.repairs.nan_samples, 0);
    EXPECT_EQ(decoded.repairs.negative_samples, 0);
    EXPECT_EQ(decoded.equirect.pixels, clean.equirect.pixels);
  }
}

TEST(CubeEnvironment, AMeanOfTheLargestFloatsIsFinite) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  for (const EnvironmentLayout layout : kCubes) {
    for (int side : {1, 2, 7, 16}) {
      const auto radiance = [](const Direction&) { return Rgb{kLargest, kLargest, kLargest}; };
      const Image map = equirect_of_cube(cube_of(layout, side, radiance), layout);
      for (const float sample : map.samples<float>()) ASSERT_TRUE(std::isfinite(sample)) << side;
    }
  }
}

TEST(CubeEnvironment, ItsMapIsHeldWithinTheLimits) {
  const Blob strip(encode_exr(cube_of(EnvironmentLayout::kHorizontalStrip, 8,
                                      [](const Direction&) {
                                        return Rgb{1, 1, 1};
                                      }),
                              {}));
  EXPECT_NO_THROW(decode_environment(strip, {64, 32 * 16}));
  EXPECT_EQ(sample::error_of([&] {
              decode_environment(strip, {64, 32 * 16 - 1});
            }).code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace furnace
