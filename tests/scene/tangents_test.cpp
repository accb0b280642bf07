#include "renderer/scene/tangents.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/scene/gltf_import.hpp"

namespace furnace {
namespace {

constexpr double kPi = std::numbers::pi;

Mesh quad(const std::vector<glm::vec2>& uvs) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.normals.assign(4, glm::vec3(0, 0, 1));
  mesh.uvs[0] = uvs;
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

void expect_all(const Mesh& mesh, const glm::vec4& tangent) {
  ASSERT_EQ(mesh.tangents.size(), mesh.positions.size());
  for (const glm::vec4& t : mesh.tangents) {
    EXPECT_LT(glm::distance(glm::vec3(t), glm::vec3(tangent)), 1e-6f);
    EXPECT_EQ(t.w, tangent.w);
  }
}

// glTF's v points down the image and the normal map's y up: with v = 1 - y the bitangent is +y.
TEST(Tangents, OfAQuadFollowU) {
  Mesh upright = quad({{0, 1}, {1, 1}, {1, 0}, {0, 0}});
  EXPECT_EQ(generate_tangents(upright, 0), (std::vector<std::uint32_t>{0, 1, 2, 3}));
  expect_all(upright, {1, 0, 0, 1});
  EXPECT_EQ(upright.indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));

  Mesh mirrored = quad({{1, 1}, {0, 1}, {0, 0}, {1, 0}});
  generate_tangents(mirrored, 0);
  expect_all(mirrored, {-1, 0, 0, -1});

  Mesh turned = quad({{0, 0}, {0, 1}, {1, 1}, {1, 0}});  // u along +y, v along +x
  generate_tangents(turned, 0);
  expect_all(turned, {0, 1, 0, 1});
}

TEST(Tangents, UseTheUvSetThatIsNamed) {
  Mesh mesh = quad({{0, 1}, {1, 1}, {1, 0}, {0, 0}});
  mesh.uvs[1] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  generate_tangents(mesh, 1);
  expect_all(mesh, {0, 1, 0, 1});
}

// Two squares side by side whose u runs towards their common edge from both sides: one welded row of
// vertices, two frames.
TEST(Tangents, MirroredIslandsAreSplitAtTheirSeam) {
  Mesh mesh;
  for (int x = -1; x <= 1; ++x) {
    for (int y = 0; y <= 1; ++y) {
      mesh.positions.emplace_back(x, y, 0);
      mesh.uvs[0].emplace_back(1 - std::abs(x), 1 - y);
    }
  }
  mesh.normals.assign(6, glm::vec3(0, 0, 1));
  mesh.colors = {glm::vec4(0), glm::vec4(1), glm::vec4(2), glm::vec4(3), glm::vec4(4), glm::vec4(5)};
  mesh.indices = {0, 2, 3, 0, 3, 1, 2, 4, 5, 2, 5, 3};
  const Mesh before = mesh;
  const std::vector<std::uint32_t> source = generate_tangents(mesh, 0);
  EXPECT_EQ(mesh.positions.size(), 8u);  // the two of the seam doubled
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t vertex = mesh.indices[i];
    EXPECT_EQ(source[vertex], before.indices[i]);
    EXPECT_EQ(mesh.positions[vertex], before.positions[before.indices[i]]);
    EXPECT_EQ(mesh.colors[vertex], before.colors[before.indices[i]]);
    const bool left = i < 6;
    EXPECT_EQ(mesh.tangents[vertex], left ? glm::vec4(1, 0, 0, 1) : glm::vec4(-1, 0, 0, -1));
  }
}

// Vertices that only agree by value are welded first: the frame of the fold is the mean of both faces'.
TEST(Tangents, EqualVerticesAreOne) {
  Mesh mesh;
  const glm::vec3 up = glm::normalize(glm::vec3(0, 1, 1));
  // Two squares folded along x; u runs across the fold, vertices given twice, with the normal of the fold
  // everywhere.
  mesh.positions = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}, {0, 1, 0}};
  mesh.uvs[0] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 0}};
  mesh.normals.assign(8, up);
  mesh.indices = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
  generate_tangents(mesh, 0);
  const glm::vec3 expected = glm::normalize(glm::vec3(0, 1, -1));
  for (const std::uint32_t vertex : mesh.indices) {
    EXPECT_LT(glm::distance(glm::vec3(mesh.tangents[vertex]), expected), 1e-6f);
    EXPECT_EQ(mesh.tangents[vertex].w, 1);
  }
}

// A corner of 90 degrees beside one of 45: the mean is weighted by the angles, Mikkelsen 2008, section 2.4.
TEST(Tangents, AreWeightedByCornerAngles) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
  mesh.normals.assign(4, glm::vec3(0, 0, 1));
  mesh.uvs[0] = {{0, 1}, {1, 1}, {0, 0}, {-1, 0.5f}};  // the second triangle's map is skewed
  mesh.indices = {0, 2, 3};
  Mesh second = mesh;
  generate_tangents(second, 0);
  const glm::vec4 skewed = second.tangents[second.indices[0]];
  ASSERT_EQ(skewed.w, 1);
  ASSERT_GT(glm::distance(glm::vec3(skewed), glm::vec3(1, 0, 0)), 0.1f);

  mesh.indices = {0, 1, 2, 0, 2, 3};
  generate_tangents(mesh, 0);
  const glm::vec3 expected =
      glm::normalize(float(kPi / 2) * glm::vec3(1, 0, 0) + float(kPi / 4) * glm::vec3(skewed));
  EXPECT_LT(glm::distance(glm::vec3(mesh.tangents[mesh.indices[0]]), expected), 1e-6f);
}

Mesh sphere(int columns, int rows) {
  Mesh mesh;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const double azimuth = 2 * kPi * column / columns, polar = kPi * row / rows;
      const glm::dvec3 p(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                         -std::sin(polar) * std::sin(azimuth));
      mesh.positions.emplace_back(p);
      mesh.normals.emplace_back(p);
      mesh.uvs[0].emplace_back(double(column) / columns, double(row) / rows);
    }
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto a = static_cast<std::uint32_t>(row * (columns + 1) + column), b = a + 1;
      const std::uint32_t c = a + static_cast<std::uint32_t>(columns) + 1, d = c + 1;
      mesh.indices.insert(mesh.indices.end(), {a, c, d, a, d, b});
    }
  }
  return mesh;
}

TEST(Tangents, OfASphereRunAlongTheParallels) {
  constexpr int kColumns = 64, kRows = 32;
  Mesh mesh = sphere(kColumns, kRows);
  generate_tangents(mesh, 0);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 tangent(mesh.tangents[i]);
    EXPECT_NEAR(glm::length(tangent), 1, 1e-5);
    EXPECT_NEAR(glm::dot(tangent, mesh.normals[i]), 0, 1e-5);
    EXPECT_EQ(mesh.tangents[i].w, 1);
    if (std::abs(mesh.normals[i].y) > 0.95) continue;  // at the poles the map itself has no direction
    const double azimuth = 2 * kPi * mesh.uvs[0][i].x;
    const glm::vec3 east(-std::sin(azimuth), 0, -std::cos(azimuth));
    // At the map's seam only one side counts: half a column's turn, 2.8 degrees, plus the flattening near the
    // poles.
    EXPECT_GT(glm::dot(tangent, east), std::cos(0.08)) << i;
  }
}

TEST(Tangents, DegenerateTrianglesBorrowOrInvent) {
  Mesh mesh = quad({{0, 1}, {1, 1}, {1, 0}, {0, 0}});
  mesh.positions.emplace_back(5, 5, 5);
  mesh.normals.emplace_back(0, 1, 0);
  mesh.uvs[0].emplace_back(0, 0);
  mesh.indices.insert(mesh.indices.end(), {0, 1, 1, 4, 4, 4});
  generate_tangents(mesh, 0);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(mesh.tangents[mesh.indices[i]], glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(mesh.indices[6], mesh.indices[0]);
  const glm::vec3 invented(mesh.tangents[mesh.indices[9]]);
  EXPECT_NEAR(glm::length(invented), 1, 1e-6);
  EXPECT_NEAR(glm::dot(invented, glm::vec3(0, 1, 0)), 0, 1e-6);
}

TEST(Tangents, TrianglesWithoutUvAreaJoinTheirNeighbours) {
  Mesh mesh = quad({{0, 1}, {1, 1}, {1, 0}, {0.5f, 0.5f}});  // the second triangle's map is a line
  generate_tangents(mesh, 0);
  EXPECT_EQ(mesh.tangents[mesh.indices[3]], glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(mesh.tangents[mesh.indices[4]], glm::vec4(1, 0, 0, 1));
  EXPECT_NEAR(glm::length(glm::vec3(mesh.tangents[mesh.indices[5]])), 1, 1e-6);
}

TEST(Tangents, AreUnitAndFiniteForAnyInput) {
  std::mt19937 random(7);
  const float odd[] = {0, -0.0f, 1, 1e-30f, 1e30f, -1e-38f, 3.4e38f, 0.5f};
  for (int round = 0; round < 300; ++round) {
    Mesh mesh;
    for (int i = 0; i < 12; ++i) {
      const auto pick = [&] { return odd[random() % 8]; };
      mesh.positions.emplace_back(pick(), pick(), pick());
      mesh.normals.push_back(i % 3 == 0 ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1));
      mesh.uvs[0].emplace_back(pick(), pick());
    }
    for (int i = 0; i < 60; ++i) mesh.indices.push_back(random() % 12);
    generate_tangents(mesh, 0);
    for (const glm::vec4& t : mesh.tangents) {
      EXPECT_NEAR(glm::length(glm::vec3(t)), 1, 1e-5);
      EXPECT_EQ(std::abs(t.w), 1);
    }
  }
}

// Fans around one vertex and around one edge: a quadratic algorithm would not end.
TEST(Tangents, HubsAreLinear) {
  constexpr std::uint32_t kSpokes = 50'000;
  Mesh mesh;
  mesh.positions.assign(1, glm::vec3(0));
  mesh.uvs[0].assign(1, glm::vec2(0));
  for (std::uint32_t i = 0; i <= kSpokes; ++i) {
    const double angle = 2 * kPi * i / kSpokes;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    mesh.uvs[0].emplace_back(i % 2 ? 1 : 0.5f, float(angle));
  }
  mesh.normals.assign(mesh.positions.size(), glm::vec3(0, 0, 1));
  for (std::uint32_t i = 1; i <= kSpokes; ++i) mesh.indices.insert(mesh.indices.end(), {0, i, i + 1});
  for (std::uint32_t i = 1; i <= kSpokes; ++i) mesh.indices.insert(mesh.indices.end(), {0, 1, i + 1});
  generate_tangents(mesh, 0);
  EXPECT_EQ(mesh.indices.size(), 6 * kSpokes);
}

TEST(FlatNormals, AreThoseOfTheTriangles) {
  Mesh mesh = quad({{0, 1}, {1, 1}, {1, 0}, {0, 0}});
  mesh.positions[3] = {0, 1, 1};
  mesh.tangents.assign(4, glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(generate_flat_normals(mesh), (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1));
  const glm::vec3 expected = glm::normalize(glm::cross(glm::vec3(1, 1, 0), glm::vec3(0, 1, 1)));
  EXPECT_LT(glm::distance(mesh.normals[4], expected), 1e-6f);
  EXPECT_TRUE(mesh.tangents.empty());
  EXPECT_EQ(mesh.uvs[0].size(), 6u);
}

TEST(FlatNormals, OfDegenerateTrianglesAreUnit) {
  Mesh mesh = quad({{0, 1}, {1, 1}, {1, 0}, {0, 0}});
  mesh.indices = {0, 0, 1};
  generate_flat_normals(mesh);
  EXPECT_EQ(glm::length(mesh.normals[0]), 1);
}

// Tangents in NormalTangentMirrorTest.glb came from the original MikkTSpace at export; ours must agree with
// them.
TEST(Tangents, AgreeWithThoseOfAnExporter) {
  const std::filesystem::path path = "../shared/data/models/NormalTangentMirrorTest.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs " << std::filesystem::absolute(path);
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  ModelBundle bundle;
  bundle.document = Blob(bytes.str());
  bundle.seal();
  const Scene scene = import_gltf(decode::in_process_decoder(), bundle, {}, {}, Deadline());
  for (const SharedMesh& mesh : scene.meshes) {
    const Mesh& supplied = *mesh;
    ASSERT_FALSE(supplied.tangents.empty());
    Mesh generated = supplied;
    generated.tangents.clear();
    generate_tangents(generated, 0);
    std::size_t close = 0, same_sign = 0;
    double worst = 0;
    for (std::size_t i = 0; i < supplied.indices.size(); ++i) {
      const glm::vec4 theirs = supplied.tangents[supplied.indices[i]],
                      ours = generated.tangents[generated.indices[i]];
      const double angle =
          std::acos(std::clamp(double(glm::dot(glm::vec3(theirs), glm::vec3(ours))), -1.0, 1.0));
      worst = std::max(worst, angle);
      close += angle < 0.01;
      same_sign += theirs.w == ours.w;
    }
    RecordProperty("worst_angle_rad", std::to_string(worst));
    RecordProperty("close", std::to_string(close));
    EXPECT_EQ(same_sign, supplied.indices.size());
    EXPECT_GT(close, supplied.indices.size() * 99 / 100) << worst;
  }
}

}  // namespace
}  // namespace furnace
