#include "renderer/scene/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/base/error.hpp"
#include "renderer/scene/framing.hpp"
#include "renderer/scene/procedural.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

TEST(Lens, TheOpeningIsFocalLengthOverFNumber) {
  DepthOfField spec;
  spec.f_stop = 2;
  // 24 mm of sensor seen under 2 atan(0.24) are 50 mm of focal length.
  EXPECT_NEAR(make_lens(spec, 0.24, 3).radius_m, 0.0125, 1e-12);
  spec.aperture_diameter_m = 0.1;
  EXPECT_EQ(make_lens(spec, 0.24, 3).radius_m, 0.05);
}

// Even coverage has the opening's own moments: of a disc of radius 1 a quarter each way, of a regular polygon with n corners on
// it (2 + cos(2 pi / n)) / 12.
TEST(Lens, PlacesCoverTheOpeningEvenly) {
  for (const int blades : {0, 3, 5, 6, 16}) {
    for (const int count : {16, 64, 1024}) {
      Lens lens{1, 1, blades, 0.4};
      glm::dvec2 mean(0), square(0);
      double product = 0, farthest = 0;
      for (int i = 0; i < count; ++i) {
        const glm::dvec2 at = lens_place(lens, i, count);
        mean += at / double(count);
        square += at * at / double(count);
        product += at.x * at.y / count;
        farthest = std::max(farthest, glm::length(at));
      }
      const double moment = blades == 0 ? 0.25 : (2 + std::cos(2 * kPi / blades)) / 12;
      const double tolerance = count == 16 ? 0.05 : count == 64 ? 0.02 : 0.005;
      SCOPED_TRACE(blades * 10000 + count);
      EXPECT_LT(glm::length(mean), tolerance);
      EXPECT_NEAR(square.x, moment, tolerance);
      EXPECT_NEAR(square.y, moment, tolerance);
      EXPECT_NEAR(product, 0, tolerance);
      EXPECT_LE(farthest, 1);
    }
  }
}

TEST(Lens, APolygonHasACornerOnTop) {
  const Lens lens{1, 1, 4, 0};
  for (int i = 0; i < 256; ++i) {
    const glm::dvec2 at = lens_place(lens, i, 256);
    EXPECT_LE(std::abs(at.x) + std::abs(at.y), 1 + 1e-12);
  }
}

TEST(Lens, OneSampleIsAPinhole) {
  EXPECT_EQ(lens_place({1, 1, 0, 0}, 0, 1), glm::dvec2(0));
}

Scene cube() {
  Scene scene;
  scene.meshes = {std::make_shared<const Mesh>(builtin_mesh("cube")->front())};
  scene.instances.push_back({0, 0, glm::mat4(1), ""});
  return scene;
}

CameraSpec camera_before_cube() {
  CameraSpec camera;
  camera.view = LookAtCamera{{1, 2, 6}, {0, 0, 0}, {0, 1, 0}, 0.6};
  camera.depth_of_field.emplace().aperture_diameter_m = 0.5;
  return camera;
}

TEST(Lens, IsFocusedOnTheMiddleOnADistanceOrOnAPoint) {
  const Scene scene = cube();
  CameraSpec camera = camera_before_cube();
  const double to_middle_m = std::sqrt(41.0);
  EXPECT_NEAR(make_view(camera, scene, {4, 3}).lens.focus_m, to_middle_m, 1e-5);
  camera.depth_of_field->focus_point = glm::vec3(0.5f, 1, 3);  // halfway
  EXPECT_NEAR(make_view(camera, scene, {4, 3}).lens.focus_m, to_middle_m / 2, 1e-5);
  camera.depth_of_field->focus_distance_m = 7;
  EXPECT_EQ(make_view(camera, scene, {4, 3}).lens.focus_m, 7);
}

TEST(Lens, WhatCannotBeFocusedIsRefused) {
  const Scene scene = cube();
  const auto refused_at = [&](const CameraSpec& camera) {
    try {
      make_view(camera, scene, {4, 3});
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
      return error.pointer;
    }
    return std::string("accepted");
  };
  CameraSpec camera = camera_before_cube();
  camera.depth_of_field->focus_point = glm::vec3(2, 4, 12);
  EXPECT_EQ(refused_at(camera), "/camera/depthOfField/focusPoint");
  camera.depth_of_field->focus_point.reset();
  camera.view = LookAtCamera{{0, 0, 6}, {0, 0, 7}};
  EXPECT_EQ(refused_at(camera), "/camera/depthOfField");
  OrbitCamera orbit;
  orbit.orthographic = true;
  camera.view = orbit;
  EXPECT_EQ(refused_at(camera), "/camera/depthOfField");
}

// A point on the plane of focus is seen at one place from all of the lens; others part by the thin lens' formula.
TEST(Lens, OnlyThePlaneOfFocusStays) {
  CameraSpec camera = camera_before_cube();
  camera.depth_of_field->focus_distance_m = 4;
  const View view = make_view(camera, cube(), {4, 3});
  const glm::dmat3 axes(glm::transpose(glm::mat3(view.view_from_world)));
  const auto seen = [&](const View& from, double right, double up, double depth) {
    const glm::dvec3 world = glm::dvec3(view.eye) + axes * glm::dvec3(right, up, -depth);
    const glm::dvec4 clip =
        glm::dmat4(from.clip_from_view) * glm::dmat4(from.view_from_world) * glm::dvec4(world, 1);
    return glm::dvec2(clip) / clip.w;
  };
  const glm::dvec2 place(0.2, -0.1);
  const View moved = through_lens(view, place);
  EXPECT_NEAR(glm::length(glm::dvec3(moved.eye) - glm::dvec3(view.eye)), glm::length(place), 1e-6);
  const glm::dvec2 scale(view.clip_from_view[0][0], view.clip_from_view[1][1]);
  for (const double depth : {1.0, 4.0, 9.0}) {
    const glm::dvec2 shift = seen(moved, 0.3, 0.2, depth) - seen(view, 0.3, 0.2, depth);
    const glm::dvec2 expected = scale * place * (1 / 4.0 - 1 / depth);
    EXPECT_NEAR(shift.x, expected.x, 1e-5) << depth;
    EXPECT_NEAR(shift.y, expected.y, 1e-5) << depth;
  }
}

}  // namespace
}  // namespace furnace
