#include "renderer/scene/mesh_patches.hpp"
#include "renderer/scene/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>

namespace furnace {
namespace {

Mesh mesh_of(std::vector<glm::vec3> positions) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) mesh.indices.push_back(i);
  return mesh;
}

Scene scene_of(Mesh mesh, std::vector<glm::mat4> placements) {
  Scene scene;
  scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  for (const glm::mat4& placement : placements) scene.instances.push_back({0, 0, placement, ""});
  return scene;
}

TEST(BoundsTest, StartsEmptyAndGrows) {
  Bounds bounds;
  EXPECT_TRUE(bounds.empty());
  bounds.add({1, -2, 3});
  EXPECT_FALSE(bounds.empty());
  EXPECT_EQ(bounds.min, bounds.max);
  bounds.add(Bounds{{-1, -1, -1}, {0, 0, 0}});
  EXPECT_EQ(bounds.min, glm::vec3(-1, -2, -1));
  EXPECT_EQ(bounds.max, glm::vec3(1, 0, 3));
}

TEST(BoundsTest, AddingNothingOrNotANumberChangesNothing) {
  Bounds bounds;
  bounds.add(Bounds{});
  EXPECT_TRUE(bounds.empty());
  bounds.add({1, 1, 1});
  bounds.add(glm::vec3(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_EQ(bounds.min, glm::vec3(1));
  EXPECT_EQ(bounds.max, glm::vec3(1));
}

TEST(WorldBounds, AreThoseOfTransformedVerticesNotOfTransformedBoxes) {
  // A diamond turned by 45 degrees is a square of half its diagonal; its turned box would be twice as wide.
  const Mesh diamond = mesh_of({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}});
  const glm::mat4 turned = glm::rotate(glm::mat4(1), glm::radians(45.f), glm::vec3(0, 0, 1));
  const Bounds bounds = world_bounds(scene_of(diamond, {turned}));
  const float side = std::sqrt(0.5f);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(bounds.min[i], -side, 1e-6f);  // float rotation matrix
    EXPECT_NEAR(bounds.max[i], side, 1e-6f);
  }
}

TEST(WorldBounds, CoverAllInstancesAndSkipMeshesThatDrawNothing) {
  Scene scene = scene_of(mesh_of({{0, 0, 0}, {1, 1, 1}}),
                         {glm::mat4(1), glm::translate(glm::mat4(1), glm::vec3(5, 0, 0)),
                          glm::scale(glm::mat4(1), glm::vec3(1, -3, 1))});
  Mesh empty = mesh_of({{100, 100, 100}});
  empty.indices.clear();
  scene.meshes.push_back(std::make_shared<const Mesh>(empty));
  scene.instances.push_back({1, 0, glm::mat4(1), ""});
  const Bounds bounds = world_bounds(scene);
  EXPECT_EQ(bounds.min, glm::vec3(0, -3, 0));
  EXPECT_EQ(bounds.max, glm::vec3(6, 1, 1));
}

TEST(WorldBounds, OfAnEmptySceneAreEmpty) {
  EXPECT_TRUE(world_bounds(Scene{}).empty());
}

TEST(ByteSize, CountsEveryArrayAndImage) {
  const std::size_t empty = Scene{}.byte_size();
  Scene scene;
  scene.images.push_back({Blob(std::string(1000, 'x')), "/images/0"});
  EXPECT_GE(scene.byte_size(), empty + 1000);

  const std::size_t bare = Mesh{}.byte_size();
  Mesh mesh;
  const std::size_t count = 100;
  mesh.positions.resize(count);
  mesh.normals.resize(count);
  mesh.tangents.resize(count);
  mesh.uvs[0].resize(count);
  mesh.uvs[1].resize(count);
  mesh.colors.resize(count);
  mesh.indices.resize(count);
  EXPECT_EQ(mesh.byte_size() - bare, count * (12 + 12 + 16 + 8 + 8 + 16 + 4));
  scene.meshes.push_back(std::make_shared<const Mesh>(mesh));
  EXPECT_GE(scene.byte_size(), mesh.byte_size() + 1000);
}

TEST(MeshPatches, TrianglesThatShareVerticesAreOne) {
  Mesh mesh;
  mesh.positions.resize(11);
  // A strip of three triangles that meet only at its end, one apart, and a vertex that nothing uses.
  mesh.indices = {0, 1, 2, 4, 5, 6, 2, 3, 4, 7, 8, 9};
  const std::vector<std::uint32_t> patches = mesh_patches(mesh);
  EXPECT_EQ(patches, (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 2}));
}

}  // namespace
}  // namespace furnace
