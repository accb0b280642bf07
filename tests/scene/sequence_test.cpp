#include "renderer/scene/sequence.hpp"

#include <cmath>
#include <random>

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/framing.hpp"
#include "renderer/scene/shutter.hpp"

namespace furnace {
namespace {

using ::testing::DoubleNear;
using ::testing::SizeIs;

constexpr double kPi = 3.14159265358979323846;

Scene cloud(unsigned seed, const glm::vec3& middle) {
  std::mt19937 random(seed);
  const auto unit = [&] { return float(random() / 4294967296.0 - 0.5); };
  Mesh mesh;
  mesh.topology = Topology::kPoints;
  for (std::uint32_t i = 0; i < 60; ++i) {
    mesh.positions.push_back(middle + glm::vec3(3 * unit(), unit(), 2 * unit() * unit()));
    mesh.indices.push_back(i);
  }
  Scene scene;
  scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  scene.instances.push_back({0, 0, glm::mat4(1), ""});
  return scene;
}

RenderSpec sequence_spec(int frames, double turntable_rad) {
  RenderSpec spec;
  spec.output.width = 300;
  spec.output.height = 200;
  std::get<OrbitCamera>(spec.camera.view).fit = 1;
  Sequence sequence;
  sequence.frames = frames;
  sequence.turntable_rad = turntable_rad;
  spec.output.sequence = sequence;
  return spec;
}

// `scenes[i]` is what frame i shows.
std::vector<RenderSpec> held(const RenderSpec& spec, const std::vector<Scene>& scenes) {
  std::vector<RenderSpec> frames = frames_of(spec, int(scenes.size()));
  std::vector<FrameOutline> outlines;
  for (std::size_t i = 0; i < scenes.size(); ++i) outlines.push_back(outline_of(scenes[i], frames[i].camera));
  hold_still(spec, outlines, frames);
  return frames;
}

struct Edges {
  double x = 0, y = 0;  // how far the farthest vertex is off the middle, of the frame's half side
};

Edges edges_of(const std::vector<RenderSpec>& frames, const std::vector<Scene>& scenes) {
  Edges edges;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const View view = make_view(frames[i].camera, scenes[i], {300, 200});
    for (const glm::vec3& position : scenes[i].meshes[0]->positions) {
      const glm::dvec4 clip =
          glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world) * glm::dvec4(position, 1);
      EXPECT_GT(clip.w, 0);
      edges.x = std::max(edges.x, std::abs(clip.x / clip.w));
      edges.y = std::max(edges.y, std::abs(clip.y / clip.w));
    }
  }
  return edges;
}

TEST(Sequence, FramesPlayTheClipsAndTurnTheCamera) {
  RenderSpec spec = sequence_spec(4, 2 * kPi);
  spec.scene.animations = {{0, {0.5, true}}};
  const std::vector<RenderSpec> frames = frames_of(spec, 4);
  ASSERT_THAT(frames, SizeIs(4));
  EXPECT_FALSE(frames[3].output.sequence);
  EXPECT_DOUBLE_EQ(frames[3].scene.animations[0].time.seconds, 0.5 + 3 / 24.0);
  EXPECT_NEAR(std::get<OrbitCamera>(frames[3].camera.view).azimuth_rad, 0.61 + 1.5 * kPi, 1e-12);
}

// What is seen while a frame's shutter is open follows from how fast the camera turns, and about what.
TEST(Sequence, FramesKnowHowTheyMove) {
  RenderSpec spec = sequence_spec(4, 2 * kPi);
  spec.output.sequence->frames_per_second = 8;
  const std::vector<Scene> scenes(4, cloud(4, {3, 0, 7}));
  const Bounds bounds = outline_of(scenes[0], {}).bounds;
  const glm::vec3 middle = (bounds.min + bounds.max) / 2.f;
  const std::vector<RenderSpec> frames = held(spec, scenes);
  for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
    const CameraMotion& motion = frames[i].camera.motion;
    EXPECT_DOUBLE_EQ(motion.frame_s, 1 / 8.0);
    EXPECT_DOUBLE_EQ(motion.turn_rad_per_s, 4 * kPi);
    EXPECT_NEAR(glm::distance(glm::vec3(motion.turn_about_m), middle), 0, 1e-5);
    // A frame later it is where the next one begins.
    const View now = make_view(frames[i].camera, scenes[i], {300, 200});
    const View next = make_view(frames[i + 1].camera, scenes[i], {300, 200});
    EXPECT_NEAR(glm::distance(view_at(now, motion, motion.frame_s).eye, next.eye), 0, 1e-4);
  }
}

TEST(Sequence, LookAtGoesRoundItsTargetTowardsLargerAzimuths) {
  RenderSpec spec = sequence_spec(4, 2 * kPi);
  spec.camera.view = LookAtCamera{{1, 2, 4}, {1, 0, 0}, {0, 1, 0}};
  const LookAtCamera quarter = std::get<LookAtCamera>(frames_of(spec, 4)[1].camera.view);
  EXPECT_NEAR(glm::distance(quarter.eye, glm::vec3(5, 2, 0)), 0, 1e-5);  // from +Z to +X
  EXPECT_EQ(quarter.target, glm::vec3(1, 0, 0));
}

TEST(Sequence, WithoutAFrameCountTheLongestClipGivesIt) {
  SceneSpec scene;
  scene.animations = {{1, {}}, {"walk", {}}, {"unknown", {}}};
  const std::vector<SceneAnimation> known = {{"walk", 2}, {"run", 1}, {"long", 9}};
  EXPECT_EQ(longest_clip_s(scene, known), 2);
  EXPECT_EQ(frame_count(Sequence{}, 2), 48);
  EXPECT_EQ(frame_count(Sequence{}, 0), 2);
  EXPECT_EQ(frame_count(Sequence{7}, 2), 7);
}

// A camera that need not move stands where that of a single picture stands.
TEST(Sequence, OfAStillSceneIsFramedAsThePicture) {
  const Scene scene = cloud(1, {5, 1, -2});
  for (const bool orthographic : {false, true}) {
    RenderSpec spec = sequence_spec(2, 0);
    std::get<OrbitCamera>(spec.camera.view).orthographic = orthographic;
    const std::vector<RenderSpec> frames = held(spec, {scene, scene});
    const View alone = make_view(spec.camera, scene, {300, 200});
    const View frame = make_view(frames[1].camera, scene, {300, 200});
    EXPECT_EQ(frame.orthographic, orthographic);
    for (int column = 0; column < 4; ++column)
      EXPECT_NEAR(glm::distance(alone.view_from_world[column], frame.view_from_world[column]), 0, 2e-5);
    EXPECT_NEAR(alone.clip_from_view[1][1], frame.clip_from_view[1][1], 1e-5);
  }
}

TEST(Sequence, SeesEveryFrameWholeAndFillsThePicture) {
  const std::vector<Scene> scenes = {cloud(1, {0, 0, 0}), cloud(2, {1, 0.5f, 0}), cloud(3, {2, 1, 0})};
  for (const double turn : {0.0, 2 * kPi}) {
    for (const bool orthographic : {false, true}) {
      RenderSpec spec = sequence_spec(3, turn);
      std::get<OrbitCamera>(spec.camera.view).orthographic = orthographic;
      const Edges edges = edges_of(held(spec, scenes), scenes);
      EXPECT_THAT(std::max(edges.x, edges.y), DoubleNear(1, 1e-4)) << turn << orthographic;
    }
  }
}

TEST(Sequence, ATurntableKeepsDistanceAndHeightAndItsAxisInTheMiddle) {
  const Scene scene = cloud(4, {3, 0, 7});
  const std::vector<Scene> scenes(12, scene);
  const std::vector<RenderSpec> frames = held(sequence_spec(12, 2 * kPi), scenes);
  const Bounds bounds = outline_of(scene, {}).bounds;
  const glm::vec3 middle = (bounds.min + bounds.max) / 2.f;
  const auto& first = std::get<LookAtCamera>(frames[0].camera.view);
  for (const RenderSpec& frame : frames) {
    const auto& camera = std::get<LookAtCamera>(frame.camera.view);
    EXPECT_NEAR(camera.eye.y, first.eye.y, 1e-5);
    const auto radius = [&](const glm::vec3& p) { return std::hypot(p.x - middle.x, p.z - middle.z); };
    EXPECT_NEAR(radius(camera.eye), radius(first.eye), 1e-5);
    // The axis, seen from the eye, is straight ahead.
    const glm::vec3 ahead = camera.target - camera.eye, right = glm::cross(ahead, camera.up);
    EXPECT_NEAR(glm::dot(glm::normalize(right), middle - camera.eye), 0, 1e-5);
  }
}

TEST(Sequence, GroundAndFocusAreThoseOfAllFrames) {
  RenderSpec spec = sequence_spec(2, 0);
  spec.environment.ground = GroundSpec{};
  spec.camera.depth_of_field = DepthOfField{};
  const std::vector<Scene> scenes = {cloud(1, {0, 0, 0}), cloud(1, {0, -3, 0})};
  const std::vector<RenderSpec> frames = held(spec, scenes);
  const float lowest = outline_of(scenes[1], spec.camera).bounds.min.y;
  for (const RenderSpec& frame : frames) {
    EXPECT_EQ(frame.environment.ground->level_m, double(lowest));
    EXPECT_TRUE(frame.camera.depth_of_field->focus_point);
  }
  EXPECT_EQ(frames[0].camera.depth_of_field->focus_point, frames[1].camera.depth_of_field->focus_point);
}

TEST(Sequence, AnEndlessVertexIsRefused) {
  Scene scene = cloud(1, {0, 0, 0});
  Mesh mesh = *scene.meshes[0];
  mesh.positions[7].y = std::numeric_limits<float>::quiet_NaN();
  scene.meshes = {std::make_shared<const Mesh>(std::move(mesh))};
  EXPECT_THROW(outline_of(scene, {}), Error);
}

TEST(Sequence, SaysWhatCannotBe) {
  EXPECT_EQ(sequence_fault(sequence_spec(4, 1)), "");
  EXPECT_NE(sequence_fault(sequence_spec(4, 0)), "") << "nothing moves";
  RenderSpec endless = sequence_spec(4, 1);
  endless.output.sequence->frames.reset();
  EXPECT_NE(sequence_fault(endless), "");
  RenderSpec exr = sequence_spec(4, 1);
  exr.output.format = OutputFormat::kExr;
  EXPECT_NE(sequence_fault(exr), "");
  exr.output.sequence->container = Sequence::Container::kArchive;
  EXPECT_EQ(sequence_fault(exr), "");
  RenderSpec fixed = sequence_spec(4, 1);
  fixed.camera.view = GltfCamera{};
  EXPECT_NE(sequence_fault(fixed), "");

  RenderSpec video = sequence_spec(4, 1);
  EXPECT_EQ(format_fault(video), "");
  video.output.format = OutputFormat::kWebm;
  EXPECT_EQ(format_fault(video) + sequence_fault(video), "");
  video.output.sequence->loops = 2;
  EXPECT_NE(sequence_fault(video), "") << "the player's";
  video.output.sequence->loops = 0;
  video.output.sequence->container = Sequence::Container::kArchive;
  EXPECT_NE(sequence_fault(video), "");
  video.output.sequence.reset();
  EXPECT_NE(format_fault(video), "") << "one picture";
}

}  // namespace
}  // namespace furnace
