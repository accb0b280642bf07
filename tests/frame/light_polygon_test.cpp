// Outlines of lights and their parts.
#include <cmath>

#include <gtest/gtest.h>

#include "renderer/frame/light_polygon.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

Light surface(LightKind kind) {
  Light light;
  light.kind = kind;
  light.radius_m = 0.7;
  light.width_m = 3;
  light.height_m = 0.5;
  return light;
}

TEST(LightPolygon, OutlinesAreAsLargeAsTheirLights) {
  EXPECT_NEAR(area(outline_of(surface(LightKind::kRectangle))), 1.5, 1e-12);
  EXPECT_NEAR(area(outline_of(surface(LightKind::kDisc))), kPi * 0.49, 1e-12);
  EXPECT_NEAR(area(outline_of(surface(LightKind::kSphere))), kPi * 0.49, 1e-12);
}

TEST(LightPolygon, PartsAreEqualConvexAndTogetherTheWhole) {
  for (const LightKind kind : {LightKind::kRectangle, LightKind::kDisc}) {
    const LightPolygon whole = outline_of(surface(kind));
    for (const int count : {1, 2, 3, 7, 16, 61, 256}) {
      glm::dvec2 middle(0);
      double widest = 0;
      for (int i = 0; i < count; ++i) {
        const LightPolygon part = equal_part(whole, count, i);
        ASSERT_GE(part.size(), 3u);
        ASSERT_LE(int(part.size()), kMostCorners);
        ASSERT_NEAR(area(part), area(whole) / count, 1e-9) << count << " " << i;
        for (std::size_t k = 0; k < part.size(); ++k) {
          const glm::dvec2 a = part[(k + 1) % part.size()] - part[k];
          const glm::dvec2 b = part[(k + 2) % part.size()] - part[(k + 1) % part.size()];
          ASSERT_GE(a.x * b.y - a.y * b.x, -1e-9);
          widest = std::max(widest, glm::length(part[k] - centroid(part)));
        }
        middle += centroid(part) / double(count);
      }
      // No part twice: their centres balance about that of the whole.
      EXPECT_NEAR(glm::length(middle), 0, 1e-9) << count;
      if (count < 16) continue;
      EXPECT_LT(widest, 1.6 * std::sqrt(area(whole) / count)) << count;
    }
  }
}

}  // namespace
}  // namespace furnace
