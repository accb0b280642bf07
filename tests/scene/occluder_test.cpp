#include "renderer/scene/occluder.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace furnace {
namespace {

// A unit sphere of rings, whose seam has its vertices twice, as texture coordinates make it.
Mesh sphere(int rings) {
  Mesh mesh;
  const int columns = 2 * rings;
  for (int j = 0; j <= rings; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double theta = 3.14159265358979 * j / rings, phi = 2 * 3.14159265358979 * (i % columns) / columns;
      mesh.positions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta),
                                  std::sin(theta) * std::sin(phi));
    }
  }
  const auto at = [&](int i, int j) { return std::uint32_t(j * (columns + 1) + i); };
  for (int j = 0; j < rings; ++j) {
    for (int i = 0; i < columns; ++i) {
      for (std::uint32_t index :
           {at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)})
        mesh.indices.push_back(index);
    }
  }
  return mesh;
}

// How far the triangles reach in a direction.
float reach(const Mesh& mesh, const std::vector<std::uint32_t>& indices, const glm::vec3& direction) {
  float farthest = -1;
  for (const std::uint32_t index : indices)
    farthest = std::max(farthest, glm::dot(mesh.positions[index], direction));
  return farthest;
}

TEST(Occluder, HasFewTrianglesAndTheSameOutline) {
  const Mesh mesh = sphere(100);  // 40,000 triangles
  const std::vector<std::uint32_t> few = occluder_indices(mesh, kGroundOccluder);
  EXPECT_EQ(few.size() % 3, 0u);
  EXPECT_LT(few.size() / 3, 4000u);
  EXPECT_GT(few.size() / 3, 100u);
  for (const std::uint32_t index : few) ASSERT_LT(index, mesh.positions.size());
  for (int k = 0; k < 60; ++k) {
    const float a = 0.1f * float(k), b = 0.05f * float(k);
    const glm::vec3 d(std::cos(a) * std::cos(b), std::sin(b), std::sin(a) * std::cos(b));
    EXPECT_NEAR(reach(mesh, few, d), 1, 0.01);  // 1/400 of the extent of 2, and the sphere's own facets
  }
  // No triangle cuts deeper into the sphere than that.
  for (std::size_t i = 0; i < few.size(); i += 3) {
    const glm::vec3 middle =
        (mesh.positions[few[i]] + mesh.positions[few[i + 1]] + mesh.positions[few[i + 2]]) / 3.f;
    EXPECT_GT(glm::length(middle), 0.98f);
  }
}

// What bridges the hollow of a ball darkens it, unless it lies lower than the ball's surface is lifted off its shadow: by half a
// texel of 512 to a whole one.
TEST(Occluder, BridgesNoHollowOfTheSurfaceItShadows) {
  const Mesh mesh = sphere(100);
  const std::vector<std::uint32_t> few = occluder_indices(mesh, kSurfaceOccluder);
  EXPECT_LT(few.size(), mesh.indices.size() / 3);
  constexpr float kExtent = 2, kTexel = kExtent / 512;
  float highest = 0;
  for (std::size_t i = 0; i < few.size(); i += 3) {
    const glm::vec3 &a = mesh.positions[few[i]], &b = mesh.positions[few[i + 1]],
                    &c = mesh.positions[few[i + 2]];
    for (const glm::vec3& p : {(a + b + c) / 3.f, (a + b) / 2.f, (b + c) / 2.f, (c + a) / 2.f})
      highest = std::max(highest, 1 - glm::length(p));
  }
  EXPECT_LT(highest, kTexel);
}

TEST(Occluder, OfASmallMeshIsTheMesh) {
  const Mesh mesh = sphere(10);
  EXPECT_EQ(occluder_indices(mesh, kGroundOccluder), mesh.indices);
}

// Nothing can be taken from it without a hole.
TEST(Occluder, ScatteredTrianglesStay) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const glm::vec3 corner(float(i % 60), float(i / 60), float(i % 7));
    mesh.positions.insert(mesh.positions.end(),
                          {corner, corner + glm::vec3(0.9f, 0, 0), corner + glm::vec3(0, 0.9f, 0)});
    mesh.indices.insert(mesh.indices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  EXPECT_GT(occluder_indices(mesh, kGroundOccluder).size(), mesh.indices.size() * 9 / 10);
}

}  // namespace
}  // namespace furnace
