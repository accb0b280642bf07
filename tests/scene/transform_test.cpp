#include "renderer/scene/transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace furnace {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Float matrices: a few roundings of numbers near 1.
constexpr float kTolerance = 1e-6f;

glm::vec3 project(const glm::mat4& matrix, const glm::vec3& point) {
  const glm::vec4 clip = matrix * glm::vec4(point, 1);
  return glm::vec3(clip) / clip.w;
}

void expect_near(const glm::vec3& actual, const glm::vec3& expected, float tolerance = kTolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

TEST(PerspectiveReversed, MapsCornersOfBothPlanesToTheClipCube) {
  const double fov = radians_from_degrees(60), aspect = 1.5, z_near = 0.25, z_far = 8;
  const glm::mat4 clip = perspective_reversed(fov, aspect, z_near, z_far);
  const double tangent = std::tan(fov / 2);
  expect_near(project(clip, glm::dvec3(tangent * aspect * z_near, tangent * z_near, -z_near)), {1, 1, 1});
  expect_near(project(clip, glm::dvec3(-tangent * aspect * z_far, -tangent * z_far, -z_far)), {-1, -1, 0});
}

TEST(PerspectiveReversed, InfiniteFarPlaneHasDepthNearOverDistance) {
  const glm::mat4 clip = perspective_reversed(1, 1, 0.5, kInfinity);
  EXPECT_NEAR(project(clip, {0, 0, -0.5f}).z, 1, kTolerance);
  EXPECT_NEAR(project(clip, {0, 0, -2}).z, 0.25f, kTolerance);
  EXPECT_EQ((clip * glm::vec4(0, 0, -1, 0)).z, 0);  // a point at infinity
}

TEST(PerspectiveReversed, NearerIsLarger) {
  const glm::mat4 clip = perspective_reversed(1, 1, 0.1, 100);
  EXPECT_GT(project(clip, {0, 0, -1}).z, project(clip, {0, 0, -2}).z);
}

TEST(OrthographicReversed, MapsCornersOfTheBoxToTheClipCube) {
  const glm::mat4 clip = orthographic_reversed(3, 2, 1, 5);
  expect_near(project(clip, {3, 2, -1}), {1, 1, 1});
  expect_near(project(clip, {-3, -2, -5}), {-1, -1, 0});
  expect_near(project(clip, {0, 0, -3}), {0, 0, 0.5f});
}

TEST(LookAt, PutsTheTargetOnTheAxisAndUpAbove) {
  const glm::vec3 eye{1, 2, 3}, target{-2, 0.5f, 4};
  const glm::mat4 view = look_at(eye, target, {0, 1, 0});
  expect_near(project(view, eye), {0, 0, 0});
  expect_near(project(view, target), {0, 0, -glm::length(target - eye)});
  const glm::vec3 above = project(view, target + glm::vec3(0, 1, 0));
  EXPECT_NEAR(above.x, 0, kTolerance);
  EXPECT_GT(above.y, 0);
}

TEST(LookAt, ASideWardsUpVectorRollsThePicture) {
  const glm::mat4 view = look_at({0, 0, 5}, {0, 0, 0}, {1, 0, 0});
  expect_near(project(view, {1, 0, 0}), {0, 1, -5});
  expect_near(project(view, {0, 1, 0}), {-1, 0, -5});
}

TEST(LookAt, UpAlongTheViewFallsBackToAnotherAxis) {
  expect_near(project(look_at({0, 5, 0}, {0, 0, 0}, {0, 1, 0}), {0, 0, -1}), {0, 1, -5});  // down: -Z is up
  expect_near(project(look_at({0, -5, 0}, {0, 0, 0}, {0, 1, 0}), {0, 0, 1}), {0, 1, -5});  // up: +Z is up
  expect_near(project(look_at({0, 0, 5}, {0, 0, 0}, {0, 0, 7}), {0, 1, 0}), {0, 1, -5});
  expect_near(project(look_at({0, 0, 5}, {0, 0, 0}, {0, 0, 0}), {0, 1, 0}), {0, 1, -5});
}

TEST(LookAt, IsARotationEvenForATinyUpVector) {
  const glm::mat3 view(look_at({3, -1, 2}, {0, 4, 1}, {0, 1e-30f, 1e-30f}));
  const glm::mat3 product = view * glm::transpose(view);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(product[i][j], i == j, kTolerance);
  EXPECT_NEAR(glm::determinant(view), 1, kTolerance);
}

TEST(ViewFromAxes, AFarEyeIsTranslatedInDouble) {
  const glm::dvec3 eye(0, 0, 123456789.0);
  const glm::mat4 view = view_from_axes(glm::dmat3(1), eye);
  EXPECT_EQ(view[3].z, float(-123456789.0));
}

}  // namespace
}  // namespace furnace
