#include "renderer/scene/procedural.hpp"

#include "renderer/scene/transform.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>

namespace furnace {
namespace {

Mesh only_mesh(std::string_view name) {
  const auto meshes = builtin_mesh(name);
  EXPECT_TRUE(meshes.has_value());
  EXPECT_EQ(meshes->size(), 1u);
  return meshes->front();
}

std::vector<Mesh> all_meshes() {
  std::vector<Mesh> all;
  for (const std::string_view name : builtin_mesh_names()) {
    const std::vector<Mesh> parts = *builtin_mesh(name);
    all.insert(all.end(), parts.begin(), parts.end());
  }
  return all;
}

std::array<glm::dvec3, 3> corners(const Mesh& mesh, std::size_t triangle) {
  std::array<glm::dvec3, 3> points;
  for (int k = 0; k < 3; ++k) points[k] = mesh.positions[mesh.indices[3 * triangle + k]];
  return points;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i) {
    const auto [a, b, c] = corners(mesh, i);
    sum += glm::length(glm::cross(b - a, c - a)) / 2;
  }
  return sum;
}

// Positive when triangles wind counter-clockwise seen from outside (divergence theorem).
double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i) {
    const auto [a, b, c] = corners(mesh, i);
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

// Vertices at exactly one place are one corner.
struct Topology2d {
  std::size_t corners = 0, edges = 0, triangles = 0;
  bool every_edge_has_two_opposite_sides = true;

  long euler() const { return long(corners) - long(edges) + long(triangles); }
};

Topology2d weld(const Mesh& mesh) {
  std::map<std::tuple<float, float, float>, int> ids;
  std::vector<int> corner;
  for (const glm::vec3& p : mesh.positions)
    corner.push_back(ids.emplace(std::tuple(p.x + 0.f, p.y + 0.f, p.z + 0.f), int(ids.size())).first->second);
  std::map<std::pair<int, int>, int> half_edges;
  std::set<int> used;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    for (int k = 0; k < 3; ++k) {
      const int from = corner[mesh.indices[i + k]], to = corner[mesh.indices[i + (k + 1) % 3]];
      used.insert(from);
      ++half_edges[{from, to}];
    }
  Topology2d topology{used.size(), half_edges.size() / 2, mesh.indices.size() / 3, true};
  for (const auto& [edge, count] : half_edges) {
    const auto opposite = half_edges.find({edge.second, edge.first});
    if (count != 1 || edge.first == edge.second || opposite == half_edges.end())
      topology.every_edge_has_two_opposite_sides = false;
  }
  return topology;
}

TEST(BuiltinMesh, ContractNamesExistAndOthersDoNot) {
  EXPECT_THAT(builtin_mesh_names(),
              testing::UnorderedElementsAre("sphere", "cube", "plane", "cylinder", "torus", "shader-ball"));
  EXPECT_FALSE(builtin_mesh("teapot").has_value());
  EXPECT_FALSE(builtin_mesh("").has_value());
}

TEST(BuiltinMesh, ArraysAreWholeAndIndicesInRange) {
  for (const Mesh& mesh : all_meshes()) {
    SCOPED_TRACE(mesh.name);
    const std::size_t count = mesh.positions.size();
    EXPECT_EQ(mesh.normals.size(), count);
    EXPECT_EQ(mesh.tangents.size(), count);
    EXPECT_EQ(mesh.uvs[0].size(), count);
    EXPECT_TRUE(mesh.uvs[1].empty());
    EXPECT_TRUE(mesh.colors.empty());
    ASSERT_FALSE(mesh.indices.empty());
    EXPECT_EQ(mesh.indices.size() % 3, 0u);
    for (const std::uint32_t index : mesh.indices) ASSERT_LT(index, count);
    Bounds bounds;
    for (const glm::vec3& position : mesh.positions) bounds.add(position);
    EXPECT_EQ(mesh.bounds.min, bounds.min);
    EXPECT_EQ(mesh.bounds.max, bounds.max);
    for (const glm::vec2& uv : mesh.uvs[0]) {
      ASSERT_GE(std::min(uv.x, uv.y), 0);
      ASSERT_LE(std::max(uv.x, uv.y), 1);
    }
  }
}

TEST(BuiltinMesh, FramesAreOrthonormal) {
  for (const Mesh& mesh : all_meshes()) {
    SCOPED_TRACE(mesh.name);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const glm::vec3 tangent(mesh.tangents[i]);
      ASSERT_NEAR(glm::length(mesh.normals[i]), 1, 1e-6);  // rounded to float once
      ASSERT_NEAR(glm::length(tangent), 1, 1e-6);
      ASSERT_NEAR(glm::dot(mesh.normals[i], tangent), 0, 1e-6);
      ASSERT_EQ(std::abs(mesh.tangents[i].w), 1);
    }
  }
}

// The definition of a tangent frame, by finite differences over each triangle: dP/du along the tangent, and
// as v runs downwards dP/dv against the bitangent.
TEST(BuiltinMesh, TangentFramesFollowTheUvs) {
  for (const Mesh& mesh : all_meshes()) {
    SCOPED_TRACE(mesh.name);
    for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i) {
      const auto [a, b, c] = corners(mesh, i);
      std::array<glm::dvec2, 3> uv;
      glm::dvec3 normal(0), tangent(0);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t index = mesh.indices[3 * i + k];
        uv[k] = mesh.uvs[0][index];
        normal += glm::dvec3(mesh.normals[index]);
        tangent += glm::dvec3(mesh.tangents[index]);
      }
      const glm::dvec2 d1 = uv[1] - uv[0], d2 = uv[2] - uv[0];
      const double determinant = d1.x * d2.y - d2.x * d1.y;
      ASSERT_NE(determinant, 0);
      const glm::dvec3 dp_du = ((b - a) * d2.y - (c - a) * d1.y) / determinant;
      const glm::dvec3 dp_dv = ((c - a) * d1.x - (b - a) * d2.x) / determinant;
      const double w = mesh.tangents[mesh.indices[3 * i]].w;
      const glm::dvec3 bitangent = w * glm::cross(normal, tangent);
      // Facets turn by some degrees from their smooth frame; a wrong sign or swapped axis is off by 90 or
      // 180.
      ASSERT_GT(glm::dot(glm::normalize(dp_du), glm::normalize(tangent)), 0.98);
      ASSERT_LT(glm::dot(glm::normalize(dp_dv), glm::normalize(bitangent)), -0.98);
    }
  }
}

TEST(BuiltinMesh, NormalsAgreeWithTheFacets) {
  for (const Mesh& mesh : all_meshes()) {
    SCOPED_TRACE(mesh.name);
    for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i) {
      const auto [a, b, c] = corners(mesh, i);
      const glm::dvec3 facet = glm::normalize(glm::cross(b - a, c - a));
      for (int k = 0; k < 3; ++k)
        // At most one step of an arc (10 degrees) lies between a facet and its vertices' normals.
        ASSERT_GT(glm::dot(facet, glm::dvec3(mesh.normals[mesh.indices[3 * i + k]])), std::cos(0.18)) << i;
    }
  }
}

TEST(BuiltinMesh, SolidsAreWatertightWithTheRightGenus) {
  for (const Mesh& mesh : all_meshes()) {
    SCOPED_TRACE(mesh.name);
    if (mesh.name == "plane") continue;
    const Topology2d topology = weld(mesh);
    EXPECT_TRUE(topology.every_edge_has_two_opposite_sides);
    EXPECT_EQ(topology.euler(), mesh.name == "torus" || mesh.name == "core" ? 0 : 2);
    EXPECT_GT(signed_volume(mesh), 0);
  }
}

TEST(Sphere, IsRoundWithNormalsAlongThePosition) {
  const Mesh mesh = only_mesh("sphere");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    ASSERT_NEAR(glm::length(mesh.positions[i]), 0.5, 1e-7);  // float rounding
    ASSERT_LT(glm::length(2.f * mesh.positions[i] - mesh.normals[i]), 1e-6f);
  }
  // Inscribed facets: short by (pi/72)^2 / 6 and its like along the other axis, about 1e-3.
  EXPECT_NEAR(area(mesh), kPi, 2e-3 * kPi);
  EXPECT_NEAR(signed_volume(mesh), kPi / 6, 3e-3 * kPi / 6);
  EXPECT_EQ(mesh.bounds.max, glm::vec3(0.5f));
  EXPECT_EQ(mesh.bounds.min, glm::vec3(-0.5f));
}

TEST(Sphere, SilhouetteIsSmoothAt1024Pixels) {
  const Mesh mesh = only_mesh("sphere");
  double sagitta = 0;
  for (std::size_t i = 0; i < mesh.indices.size() / 3; ++i) {
    const auto p = corners(mesh, i);
    for (int k = 0; k < 3; ++k) sagitta = std::max(sagitta, 0.5 - glm::length(p[k] + p[(k + 1) % 3]) / 2);
  }
  EXPECT_LT(sagitta * 1024, 0.5);
}

TEST(Sphere, TextureStandsUprightWithItsMiddleTowardsPositiveZ) {
  const Mesh mesh = only_mesh("sphere");
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 p = mesh.positions[i];
    const glm::vec2 uv = mesh.uvs[0][i];
    ASSERT_NEAR(uv.y, std::acos(std::min(1.f, p.y / 0.5f)) / kPi,
                2e-3);  // acos of rounded numbers near the poles
    if (std::hypot(p.x, p.z) < 1e-3f) continue;
    const double turn = std::atan2(p.x, p.z) / (2 * kPi) + 0.5;
    ASSERT_NEAR(std::remainder(uv.x - turn, 1.0), 0, 1e-5);
  }
}

TEST(Cube, HasSixFlatFaces) {
  const Mesh mesh = only_mesh("cube");
  EXPECT_EQ(mesh.positions.size(), 24u);
  EXPECT_DOUBLE_EQ(area(mesh), 6);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 1);
  EXPECT_EQ(mesh.bounds.min, glm::vec3(-0.5f));
  EXPECT_EQ(mesh.bounds.max, glm::vec3(0.5f));
}

TEST(Plane, IsASquareMetreFacingUp) {
  const Mesh mesh = only_mesh("plane");
  EXPECT_DOUBLE_EQ(area(mesh), 1);
  for (const glm::vec3& normal : mesh.normals) EXPECT_EQ(normal, glm::vec3(0, 1, 0));
  EXPECT_EQ(mesh.bounds.min, glm::vec3(-0.5f, 0, -0.5f));
  EXPECT_EQ(mesh.bounds.max, glm::vec3(0.5f, 0, 0.5f));
}

TEST(Cylinder, MatchesItsClosedForms) {
  const Mesh mesh = only_mesh("cylinder");
  // A prism over a regular 144-gon.
  const double half = kPi / 144, base = 144 * 0.25 * std::sin(half) * std::cos(half);
  EXPECT_NEAR(signed_volume(mesh), base, 1e-6);
  EXPECT_NEAR(area(mesh), 2 * base + 144 * std::sin(half), 1e-5);
  EXPECT_EQ(mesh.bounds.max.y, 0.5f);
  EXPECT_EQ(mesh.bounds.min.y, -0.5f);
}

TEST(Torus, MatchesItsClosedForms) {
  const Mesh mesh = only_mesh("torus");
  const double major = 0.35, minor = 0.15;
  // Inscribed facets: within a third of a percent.
  EXPECT_NEAR(area(mesh) / (4 * kPi * kPi * major * minor), 1, 3e-3);
  EXPECT_NEAR(signed_volume(mesh) / (2 * kPi * kPi * major * minor * minor), 1, 5e-3);
  EXPECT_FLOAT_EQ(mesh.bounds.max.x, 0.5f);
  EXPECT_NEAR(mesh.bounds.max.y, 0.15f, 2e-4);  // the tube's top lies between two of its steps
}

TEST(ShaderBall, StandsOnTheFloorAboutOneMetreWide) {
  const auto meshes = builtin_mesh("shader-ball");
  ASSERT_EQ(meshes->size(), 3u);
  Bounds bounds;
  for (const Mesh& mesh : *meshes) bounds.add(mesh.bounds);
  EXPECT_NEAR(bounds.min.y, 0, 1e-7);
  EXPECT_NEAR(bounds.max.x - bounds.min.x, 0.9, 0.1);
  EXPECT_NEAR(bounds.max.x + bounds.min.x, 0, 1e-3);
  EXPECT_NEAR(bounds.max.z + bounds.min.z, 0, 1e-3);
}

TEST(ShaderBall, BodyTakesTheUsersMaterialTheRestIsNeutral) {
  const auto meshes = builtin_mesh("shader-ball");
  EXPECT_EQ(meshes->at(0).name, "body");
  for (const std::string_view name : builtin_mesh_names())
    EXPECT_FALSE(builtin_part_material(builtin_mesh(name)->at(0).name).has_value()) << name;
  for (std::size_t i = 1; i < meshes->size(); ++i) {
    const auto material = builtin_part_material(meshes->at(i).name);
    ASSERT_TRUE(material.has_value());
    EXPECT_EQ(material->base_color.r, material->base_color.g);
    EXPECT_EQ(material->base_color.g, material->base_color.b);
  }
}

// The parts must not cut into each other: band and cup keep off the orb's envelope.
TEST(ShaderBall, PartsDoNotTouch) {
  const auto meshes = *builtin_mesh("shader-ball");
  glm::vec3 centre(0);
  float radius = 0;
  centre.y = (meshes[0].bounds.min.y + meshes[0].bounds.max.y) / 2;
  for (const glm::vec3& p : meshes[0].positions) radius = std::max(radius, glm::length(p - centre));
  for (const glm::vec3& p : meshes[1].positions) EXPECT_LT(glm::length(p - centre), radius);
  for (const glm::vec3& p : meshes[2].positions) EXPECT_GT(glm::length(p - centre), radius);
}

}  // namespace
}  // namespace furnace
