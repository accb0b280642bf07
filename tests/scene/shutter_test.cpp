#include "renderer/scene/shutter.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>

#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

using ::testing::Each;
using ::testing::Ge;
using ::testing::Le;
using ::testing::SizeIs;

TEST(Shutter, EveryPartOfItIsSeenAsOften) {
  for (const int subframes : {2, 3, 16, 64, 100, 257}) {
    const int moments = std::min(subframes, kMostMoments);
    const std::vector<int> moment_of = moment_of_subframes(subframes, moments);
    ASSERT_THAT(moment_of, SizeIs(subframes));
    std::vector<int> counts(std::size_t(moments), 0);
    for (const int moment : moment_of) ++counts.at(std::size_t(moment));
    EXPECT_THAT(counts, Each(Ge(subframes / moments)));
    EXPECT_THAT(counts, Each(Le((subframes + moments - 1) / moments)));

    // What moves evenly has the shutter's middle as its mean, and each moment lies in its own part.
    const std::vector<double> offsets_s = moment_offsets_s(subframes, moments, 0.5);
    double mean_s = 0;
    for (const int moment : moment_of) mean_s += offsets_s[std::size_t(moment)] / subframes;
    EXPECT_NEAR(mean_s, 0, 1e-12);
    EXPECT_TRUE(std::is_sorted(offsets_s.begin(), offsets_s.end()));
    EXPECT_NEAR(offsets_s.front(), -0.25 + 0.25 * counts[0] / subframes, 1e-12);
    EXPECT_NEAR(offsets_s.back(), 0.25 - 0.25 * counts.back() / subframes, 1e-12);
  }
}

// Time must not go with the order of sub-frames, in which lights take their places round a sphere.
TEST(Shutter, TimesAreSpreadOverTheSubFrames) {
  const std::vector<int> moment_of = moment_of_subframes(64, 64);
  for (int first = 0; first < 64; first += 16) {
    std::set<int> quarters;
    for (int i = first; i < first + 16; ++i) quarters.insert(moment_of[std::size_t(i)] / 16);
    EXPECT_THAT(quarters, SizeIs(4));
  }
}

TEST(Shutter, IsOpenOnlyForWhatMoves) {
  RenderSpec spec;
  spec.output.samples = 16;
  spec.camera.motion.shutter_s = 0.1;
  EXPECT_EQ(moments_wanted(spec), 0);
  spec.scene.animations = {{0, {}}};
  EXPECT_EQ(moments_wanted(spec), 16);
  spec.output.samples = 1000;
  EXPECT_EQ(moments_wanted(spec), kMostMoments);
  spec.output.samples = 1;
  EXPECT_EQ(moments_wanted(spec), 0);
  spec.output.samples = 16;
  spec.camera.motion.shutter_s = 0;
  EXPECT_EQ(moments_wanted(spec), 0);
  spec.camera.motion.shutter_s = 0.1;
  spec.scene.animations.clear();
  spec.camera.motion.turn_rad_per_s = 1;
  EXPECT_EQ(moments_wanted(spec), 16);
}

TEST(Shutter, ACameraTurnsTowardsLargerAzimuthsAboutItsAxis) {
  View view;
  view.view_from_world = look_at({1, 2, 4}, {1, 0, 0}, {0, 1, 0});
  view.eye = {1, 2, 4};
  CameraMotion motion;
  motion.turn_rad_per_s = kPi;
  motion.turn_about_m = {1, 0, 0};
  const View turned = view_at(view, motion, 0.5);
  EXPECT_LT(glm::distance(turned.eye, glm::vec3(5, 2, 0)), 1e-5f);
  const glm::mat4 expected = look_at({5, 2, 0}, {1, 0, 0}, {0, 1, 0});
  for (int column = 0; column < 4; ++column)
    EXPECT_LT(glm::distance(turned.view_from_world[column], expected[column]), 1e-5f);
  EXPECT_EQ(view_at(view, motion, 0).view_from_world, view.view_from_world);
}

SharedMesh triangle() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.indices = {0, 1, 2};
  for (const glm::vec3& position : mesh.positions) mesh.bounds.add(position);
  return std::make_shared<const Mesh>(std::move(mesh));
}

TEST(Shutter, ASweptSceneHasEachPlaceOnce) {
  Scene middle;
  middle.meshes = {triangle()};
  middle.instances = {Instance{}};
  Scene moved = middle;
  moved.instances[0].world_from_model = glm::translate(glm::mat4(1), glm::vec3(2, 0, 0));
  Scene deformed = middle;
  deformed.meshes = {triangle()};
  const std::vector<const Scene*> moments = {&middle, &moved, &moved, &deformed};
  const Scene swept = swept_scene(middle, moments);
  EXPECT_THAT(swept.instances, SizeIs(3));
  EXPECT_THAT(swept.meshes, SizeIs(2));
  EXPECT_EQ(world_bounds(swept).max, glm::vec3(3, 1, 0));
}

}  // namespace
}  // namespace furnace
