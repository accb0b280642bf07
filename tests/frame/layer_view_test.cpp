// What a film layer's numbers look like.
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "renderer/frame/layer_view.hpp"

namespace furnace {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

// From (0, 0, 10) towards -Z.
View from_ten_metres() {
  View view;
  view.eye = {0, 0, 10};
  view.view_from_world[3] = {0, 0, -10, 1};
  return view;
}

Bounds unit_bounds() {
  return {glm::vec3(-1), glm::vec3(1)};
}

Image numbers_of(const std::vector<glm::vec4>& pixels) {
  Image image = make_image({int(pixels.size()), 1}, 4, SampleType::kFloat32, ColorSpace::kNonColor);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    for (std::size_t c = 0; c < 4; ++c) image.samples<float>()[4 * i + c] = pixels[i][int(c)];
  return image;
}

FramePlan plan_of(FilmLayer shown, OutputFormat format = OutputFormat::kPng) {
  RenderSpec spec;
  spec.output.shown = shown;
  spec.output.format = format;
  return plan_frame(spec, 1024);
}

glm::ivec3 pixel(const Image& image, std::size_t i) {
  const auto samples = image.samples<std::uint8_t>();
  const std::size_t at = i * std::size_t(image.channels);
  return {samples[at], samples[at + 1], samples[at + 2]};
}

Image view(FilmLayer shown, const std::vector<glm::vec4>& pixels) {
  return view_of(numbers_of(pixels), plan_of(shown), from_ten_metres(), unit_bounds());
}

TEST(LayerView, DepthsRunThroughTheBounds) {
  const DepthRange range = depth_range(from_ten_metres(), unit_bounds());
  EXPECT_DOUBLE_EQ(range.near_m, 9);
  EXPECT_DOUBLE_EQ(range.far_m, 11);
  const Image image =
      view(FilmLayer::kDepth, {{9, 0, 0, 1}, {10, 0, 0, 1}, {11, 0, 0, 1}, {kNothing, 0, 0, 0}});
  EXPECT_EQ(pixel(image, 0), glm::ivec3(255));
  EXPECT_EQ(pixel(image, 1), glm::ivec3(128));
  EXPECT_EQ(pixel(image, 2), glm::ivec3(0));
  EXPECT_EQ(pixel(image, 3), glm::ivec3(0));
  // Within the scene nothing is behind the eye.
  View inside = from_ten_metres();
  inside.eye = {0, 0, 0};
  EXPECT_EQ(depth_range(inside, unit_bounds()).near_m, 0);
}

TEST(LayerView, PlacesAreNotMixedAndNumbersHaveColours) {
  EXPECT_EQ(pixel(view(FilmLayer::kPosition, {{-1, 0, 1, 1}}), 0), glm::ivec3(0, 128, 255));
  EXPECT_EQ(pixel(view(FilmLayer::kUv, {{1.25f, -0.25f, 0, 1}}), 0), glm::ivec3(64, 191, 0));
  std::vector<glm::vec4> numbers;
  for (int i = 1; i <= 64; ++i) numbers.push_back({i, 0, 0, 1});
  numbers.push_back({0, 0, 0, 0});
  const Image image = view(FilmLayer::kObjectId, numbers);
  std::set<std::tuple<int, int, int>> colors;
  for (std::size_t i = 0; i < 64; ++i) {
    const glm::ivec3 color = pixel(image, i);
    EXPECT_GT(color.r + color.g + color.b, 150);
    colors.insert({color.r, color.g, color.b});
  }
  EXPECT_GT(colors.size(), 60u);
  EXPECT_EQ(pixel(image, 64), glm::ivec3(0));
}

// Means are premultiplied: half covered, a normal is seen as it is, and then half over black.
TEST(LayerView, MeansAreMadeStraight) {
  EXPECT_EQ(pixel(view(FilmLayer::kNormal, {{0, 0.5f, 0, 0.5f}}), 0), glm::ivec3(64, 128, 64));
  EXPECT_EQ(pixel(view(FilmLayer::kDistribution, {{1, 0, 0, 1}}), 0), glm::ivec3(128));
  EXPECT_EQ(pixel(view(FilmLayer::kWireframe, {{1, 0, 0, 1}, {0, 0, 0, 1}}), 1), glm::ivec3(51));
  FramePlan transparent = plan_of(FilmLayer::kNormal);
  transparent.opaque = false;
  const Image image =
      view_of(numbers_of({{0, 0.5f, 0, 0.5f}}), transparent, from_ten_metres(), unit_bounds());
  ASSERT_EQ(image.channels, 4);
  EXPECT_EQ(pixel(image, 0), glm::ivec3(128, 255, 128));
  EXPECT_EQ(image.samples<std::uint8_t>()[3], 128);
}

TEST(LayerView, AnExrHasTheNumbersThemselves) {
  const auto linear = [](FilmLayer shown, const glm::vec4& numbers) {
    return view_of(numbers_of({numbers}), plan_of(shown, OutputFormat::kExr), from_ten_metres(),
                   unit_bounds());
  };
  const Image depth = linear(FilmLayer::kDepth, {9.87654f, 0, 0, 1});
  EXPECT_EQ(depth.type, SampleType::kFloat32);
  ASSERT_EQ(depth.channels, 1);
  EXPECT_EQ(depth.samples<float>()[0], 9.87654f);
  const Image normal = linear(FilmLayer::kNormal, {-0.25f, 0.5f, 0, 0.5f});
  EXPECT_EQ(normal.type, SampleType::kFloat16);
  ASSERT_EQ(normal.channels, 3);
  EXPECT_EQ(float_from_half(normal.samples<std::uint16_t>()[0]), -0.25f);
}

}  // namespace
}  // namespace furnace
