// Triangles of polygons: all turn as the polygon does, and together they have its area.
#include "renderer/scene/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

using Indices = std::vector<std::uint32_t>;

// Turned into space.
void expect_cut(const std::vector<glm::dvec2>& outline, double area) {
  std::vector<glm::vec3> corners;
  for (const glm::dvec2& p : outline) corners.emplace_back(p.x, p.y + 2 * p.x, 3 - p.y);
  const glm::dvec3 across = glm::cross(glm::dvec3(1, 2, 0), glm::dvec3(0, 1, -1));
  Indices triangles;
  PolygonCutter().cut(corners, triangles);
  ASSERT_EQ(triangles.size(), 3 * (outline.size() - 2));
  double sum = 0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const glm::dvec3 a = corners[triangles[i]], b = corners[triangles[i + 1]], c = corners[triangles[i + 2]];
    const double part = glm::dot(glm::cross(b - a, c - a), across) / glm::dot(across, across) / 2;
    EXPECT_GT(part, -1e-6);
    sum += part;
  }
  EXPECT_NEAR(sum, area, 1e-5 * std::max(1.0, area));
}

TEST(Polygon, ConcaveOnesAreCutInside) {
  expect_cut({{0, 0}, {2, 1}, {0, 2}, {0.5, 1}}, 1.5);                      // a dart
  expect_cut({{0, 2}, {0.5, 1}, {0, 0}, {2, 1}}, 1.5);                      // from its other end
  expect_cut({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}, 5);          // an L
  expect_cut({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {1, 1}, {0, 1}}, 3);  // with a straight angle
  // A square with a square hole, reached by a side that is walked twice.
  expect_cut({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}}, 12);
  std::vector<glm::dvec2> comb;
  for (int i = 0; i < 100; ++i) comb.insert(comb.end(), {{2 * i, 0}, {2 * i + 1, 5}, {2 * i + 2, 0}});
  comb.insert(comb.end(), {{200, -1}, {0, -1}});
  std::ranges::reverse(comb);
  expect_cut(comb, 100 * 5 + 200);
}

// About a centre at random radii: simple, seldom seen whole from a corner.
TEST(Polygon, RandomOutlinesKeepTheirArea) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> radius(0.2, 3);
  for (int round = 0; round < 200; ++round) {
    std::vector<glm::dvec2> outline;
    const int sides = 4 + int(random() % 60);
    double area = 0;
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * 3.14159265358979 * i / sides;
      outline.push_back(glm::dvec2(std::cos(angle), std::sin(angle)) * radius(random));
    }
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const glm::dvec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
      area += (a.x * b.y - a.y * b.x) / 2;
    }
    expect_cut(outline, area);
  }
}

TEST(Polygon, SidesAreBoundedWhereWorkIsTheirSquare) {
  std::vector<glm::vec3> disc, star;
  for (int i = 0; i < 10'000; ++i) {
    const float angle = float(i) * 6.2831853f / 10'000, radius = i % 2 == 0 ? 1.0f : 0.5f;
    disc.emplace_back(std::cos(angle), std::sin(angle), 0);
    star.push_back(disc.back() * radius);
  }
  Indices triangles;
  PolygonCutter cutter;
  cutter.cut(disc, triangles);
  EXPECT_EQ(triangles.size(), 3u * (disc.size() - 2));
  EXPECT_THROW(cutter.cut(star, triangles), Error);
  star.resize(4096);
  EXPECT_NO_THROW(cutter.cut(star, triangles));
  // The work is that of all polygons together.
  PolygonCutter weak(30'000'000);
  EXPECT_NO_THROW(weak.cut(star, triangles));
  EXPECT_THROW(
      {
        for (int i = 0; i < 10; ++i) weak.cut(star, triangles);
      },
      Error);
}

}  // namespace
}  // namespace furnace
