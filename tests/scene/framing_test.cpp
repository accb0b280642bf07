#include "renderer/scene/framing.hpp"

#include "renderer/scene/procedural.hpp"
#include "renderer/scene/transform.hpp"
#include "renderer/base/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <limits>
#include <random>

namespace furnace {
namespace {

Scene scene_of(std::vector<glm::vec3> points, const glm::mat4& placement = glm::mat4(1),
               Topology topology = Topology::kPoints) {
  Mesh mesh;
  mesh.topology = topology;
  mesh.positions = std::move(points);
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) mesh.indices.push_back(i);
  Scene scene;
  scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  scene.instances.push_back({0, 0, placement, ""});
  return scene;
}

Scene builtin_scene(std::string_view name) {
  Scene scene;
  std::vector<Mesh> meshes = *builtin_mesh(name);
  for (Mesh& mesh : meshes) scene.meshes.push_back(std::make_shared<const Mesh>(std::move(mesh)));
  for (int i = 0; i < int(scene.meshes.size()); ++i) scene.instances.push_back({i, 0, glm::mat4(1), ""});
  return scene;
}

// A lopsided cloud far from the origin.
Scene random_scene(unsigned seed, double scale = 1) {
  std::mt19937 random(seed);
  const auto unit = [&] { return float(random() / 4294967296.0 - 0.5); };
  std::vector<glm::vec3> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(3 * unit(), unit(), 2 * unit() * unit());
  glm::mat4 placement = glm::scale(glm::mat4(1), glm::vec3(scale));
  placement = glm::translate(placement, glm::vec3(2, -1, 3));
  return scene_of(points, glm::rotate(placement, 1.f, glm::normalize(glm::vec3(1, 2, 3))));
}

struct Frame {
  double left = 1e30, right = -1e30, bottom = 1e30, top = -1e30, min_depth = 1e30, max_depth = -1e30;
};

// Where the vertices fall in normalised device coordinates, by the same float matrices that the shaders use.
Frame projected(const View& view, const Scene& scene) {
  Frame frame;
  for (const Instance& instance : scene.instances)
    for (const glm::vec3& position : scene.meshes[instance.mesh]->positions) {
      const glm::dvec4 clip = glm::dmat4(view.clip_from_view) * glm::dmat4(view.view_from_world) *
                              glm::dmat4(instance.world_from_model) * glm::dvec4(position, 1);
      EXPECT_GT(clip.w, 0);
      frame.left = std::min(frame.left, clip.x / clip.w);
      frame.right = std::max(frame.right, clip.x / clip.w);
      frame.bottom = std::min(frame.bottom, clip.y / clip.w);
      frame.top = std::max(frame.top, clip.y / clip.w);
      frame.min_depth = std::min(frame.min_depth, clip.z / clip.w);
      frame.max_depth = std::max(frame.max_depth, clip.z / clip.w);
    }
  return frame;
}

View orbit_view(const Scene& scene, const OrbitCamera& orbit, Extent picture) {
  return make_view(CameraSpec{orbit, {}, 0}, scene, picture);
}

// Float matrices: 2^-24 times coordinates of a few hundred half-frames leaves some 1e-5.
constexpr double kTolerance = 1e-4;

void expect_tight_and_centred(const Frame& frame, double fit) {
  EXPECT_NEAR(std::max({-frame.left, frame.right, -frame.bottom, frame.top}) * fit, 1, kTolerance);
  EXPECT_NEAR(frame.left, -frame.right, kTolerance);
  EXPECT_NEAR(frame.bottom, -frame.top, kTolerance);
  EXPECT_LT(frame.max_depth, 1);
  EXPECT_GT(frame.min_depth, 0);
}

TEST(OrbitFraming, TouchesTheFrameAndIsCentredForAllDirectionsAndAspects) {
  for (const Extent picture : {Extent{512, 512}, Extent{1600, 400}, Extent{300, 1200}})
    for (const double azimuth : {0.0, 35.0, 170.0, -100.0})
      for (const double elevation : {-90.0, -40.0, 0.0, 15.0, 90.0})
        for (const unsigned seed : {1u, 2u, 3u}) {
          SCOPED_TRACE(testing::Message() << picture.width << "x" << picture.height << " azimuth " << azimuth
                                          << " elevation " << elevation << " seed " << seed);
          const OrbitCamera orbit{radians_from_degrees(azimuth), radians_from_degrees(elevation), 1.05,
                                  0.5236};
          const Scene scene = random_scene(seed);
          expect_tight_and_centred(projected(orbit_view(scene, orbit, picture), scene), 1.05);
        }
}

TEST(OrbitFraming, HoldsForEveryBuiltinMesh) {
  for (const std::string_view name : builtin_mesh_names()) {
    SCOPED_TRACE(std::string(name));
    const Scene scene = builtin_scene(name);
    expect_tight_and_centred(projected(orbit_view(scene, OrbitCamera{}, {640, 480}), scene),
                             OrbitCamera{}.fit);
  }
}

TEST(OrbitFraming, HoldsForWideAndNarrowAnglesAndAnyFit) {
  for (const double fov : {2.0, 30.0, 90.0, 140.0})
    for (const double fit : {0.8, 1.0, 2.0}) {
      SCOPED_TRACE(testing::Message() << "fov " << fov << " fit " << fit);
      const OrbitCamera orbit{0.5, 0.3, fit, radians_from_degrees(fov)};
      const Scene scene = builtin_scene("sphere");
      expect_tight_and_centred(projected(orbit_view(scene, orbit, {800, 600}), scene), fit);
    }
}

TEST(OrbitFraming, HoldsForMillimetresAndKilometres) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    SCOPED_TRACE(scale);
    const Scene scene = random_scene(4, scale);
    expect_tight_and_centred(projected(orbit_view(scene, OrbitCamera{}, {512, 512}), scene),
                             OrbitCamera{}.fit);
  }
}

// Brute force: no nearer eye on the same axis sees all vertices, wherever it is shifted.
TEST(OrbitFraming, NoNearerEyeSeesEverything) {
  const Scene scene = random_scene(5);
  const OrbitCamera orbit{0.7, 0.4, 1, 0.6};
  const View view = orbit_view(scene, orbit, {500, 400});
  const glm::dmat4 view_from_world(view.view_from_world);
  const double tan_y = std::tan(orbit.fov_y_rad / 2), tan_x = tan_y * 1.25;
  const auto overflow =
      [&](double forward) {  // of the best shift, in units of the frame's width and height at 1 m
        double left = 1e30, right = -1e30, bottom = 1e30, top = -1e30;
        for (const glm::vec3& position : scene.meshes[0]->positions) {
          const glm::dvec3 p(view_from_world * glm::dmat4(scene.instances[0].world_from_model) *
                             glm::dvec4(position, 1));
          const double depth = -p.z - forward;
          left = std::min(left, p.x + tan_x * depth), right = std::max(right, p.x - tan_x * depth);
          bottom = std::min(bottom, p.y + tan_y * depth), top = std::max(top, p.y - tan_y * depth);
        }
        return std::max(right - left, top - bottom);
      };
  EXPECT_LE(overflow(-1e-4), 0);
  EXPECT_GT(overflow(1e-4), 0);
}

TEST(OrbitFraming, ASphereIsFramedByItsTangentCone) {
  const OrbitCamera orbit{0.2, 0.1, 1, radians_from_degrees(40)};
  const View view = orbit_view(builtin_scene("sphere"), orbit, {100, 100});
  // A polyhedron of 144 x 72 facets inside the sphere: less than 3e-4 of its radius is missing.
  EXPECT_NEAR(glm::length(view.eye), 0.5 / std::sin(orbit.fov_y_rad / 2), 1e-3);
}

TEST(OrbitFraming, LooksFromTheGivenSide) {
  const Scene scene = builtin_scene("sphere");
  const auto eye = [&](double azimuth, double elevation) {
    return glm::normalize(
        orbit_view(scene, {radians_from_degrees(azimuth), radians_from_degrees(elevation)}, {9, 9}).eye);
  };
  // The sphere's own facets move the eye off its axis by less than their size.
  EXPECT_LT(glm::length(eye(0, 0) - glm::vec3(0, 0, 1)), 1e-3f);
  EXPECT_LT(glm::length(eye(90, 0) - glm::vec3(1, 0, 0)), 1e-3f);
  EXPECT_LT(glm::length(eye(0, 90) - glm::vec3(0, 1, 0)), 1e-3f);
  EXPECT_LT(glm::length(eye(0, -90) - glm::vec3(0, -1, 0)), 1e-3f);
}

TEST(OrbitFraming, SeenFromStraightAboveTheAzimuthSaysWhatIsBelowInThePicture) {
  const Scene scene = builtin_scene("cube");
  const View view = orbit_view(scene, {radians_from_degrees(90), radians_from_degrees(90)}, {9, 9});
  const glm::vec4 clip = view.clip_from_view * view.view_from_world * glm::vec4(0.5f, 0.5f, 0, 1);
  EXPECT_LT(clip.y, 0);
  EXPECT_NEAR(clip.x, 0, kTolerance);
}

TEST(OrbitFraming, CountsLinesAndTrianglesAsPoints) {
  const std::vector<glm::vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}};
  for (const Topology topology : {Topology::kPoints, Topology::kLines, Topology::kTriangles}) {
    const Scene scene = scene_of(points, glm::mat4(1), topology);
    expect_tight_and_centred(projected(orbit_view(scene, OrbitCamera{}, {64, 64}), scene), OrbitCamera{}.fit);
  }
}

TEST(OrbitFraming, AnEmptySceneShowsTheUnitCube) {
  Scene cube = builtin_scene("cube"), empty;
  const View expected = orbit_view(cube, OrbitCamera{}, {64, 48}),
             actual = orbit_view(empty, OrbitCamera{}, {64, 48});
  EXPECT_EQ(actual.view_from_world, expected.view_from_world);
  EXPECT_EQ(actual.clip_from_view, expected.clip_from_view);
}

TEST(OrbitFraming, ASinglePointAndASpikeTowardsTheEyeKeepADistance) {
  const OrbitCamera front{0, 0, 1, 1};
  for (const std::vector<glm::vec3>& points : {std::vector<glm::vec3>{{4, 5, 6}},
                                               {{0, 0, 0}, {0, 0, 10}},
                                               {{-.1f, -.1f, 0}, {.1f, .1f, 0}, {0, 0, 10}}}) {
    const Scene scene = scene_of(points);
    const Frame frame = projected(orbit_view(scene, front, {64, 64}), scene);
    EXPECT_LT(frame.max_depth, 1);
    EXPECT_GE(frame.left, -1);
    EXPECT_LE(frame.right, 1);
  }
}

TEST(OrbitFraming, AVertexWithoutAFinitePlaceIsAnError) {
  OrbitCamera parallel;
  parallel.orthographic = true;
  const LookAtCamera look{{0, 0, 5}, {0, 0, 0}};
  for (const float bad : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()})
    for (const CameraSpec& camera :
         {CameraSpec{OrbitCamera{}, {}, 0}, CameraSpec{parallel, {}, 0}, CameraSpec{look, {}, 0}}) {
      try {
        make_view(camera, scene_of({{0, 0, 0}, {0, bad, 0}, {1, 1, 1}}), {64, 64});
        ADD_FAILURE() << bad;
      } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
        EXPECT_EQ(error.pointer, "/camera");
      }
    }
}

TEST(OrbitOrthographic, TouchesTheFrameAndIsCentred) {
  for (const Extent picture : {Extent{512, 512}, Extent{1600, 400}, Extent{300, 1200}}) {
    const OrbitCamera orbit{0.6, 0.5, 1.2, 0.5, true};
    const Scene scene = random_scene(6);
    const View view = orbit_view(scene, orbit, picture);
    EXPECT_TRUE(view.orthographic);
    expect_tight_and_centred(projected(view, scene), 1.2);
  }
}

TEST(LookAtView, ShowsTheTargetInTheMiddleAndClipsNothing) {
  const Scene scene = builtin_scene("cube");
  const View view =
      make_view({LookAtCamera{{3, 2, 1}, {0.1f, 0.2f, 0.3f}, {0, 1, 0}, 0.8}, {}, 0}, scene, {64, 32});
  EXPECT_EQ(view.eye, glm::vec3(3, 2, 1));
  const glm::vec4 clip = view.clip_from_view * view.view_from_world * glm::vec4(0.1f, 0.2f, 0.3f, 1);
  EXPECT_NEAR(clip.x / clip.w, 0, 1e-6);
  EXPECT_NEAR(clip.y / clip.w, 0, 1e-6);
  const Frame frame = projected(view, scene);
  EXPECT_LT(frame.max_depth, 1);
  EXPECT_GT(frame.min_depth, 0);
}

TEST(LookAtView, FromWithinTheSceneTheNearPlaneIsSmallAgainstIt) {
  const Scene scene = builtin_scene("sphere");
  const View view = make_view({LookAtCamera{{0, 0, 0}, {1, 0, 0}}, {}, 0}, scene, {64, 64});
  const glm::vec4 near_clip = view.clip_from_view * glm::vec4(0, 0, -1e-3f, 1);
  EXPECT_LT(near_clip.z, near_clip.w);
}

TEST(LookAtView, EyeAtTheTargetIsAnError) {
  try {
    make_view({LookAtCamera{{1, 1, 1}, {1, 1, 1}}, {}, 0}, Scene{}, {64, 64});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    EXPECT_EQ(error.pointer, "/camera/lookAt/target");
  }
}

class GltfView : public testing::Test {
 protected:
  GltfView() {
    CameraNode front;
    front.name = "front";
    front.world_from_view = glm::translate(glm::mat4(1), glm::vec3(0, 0, 5));
    front.fov_y_rad = 0.7;
    front.aspect_ratio = 2.0;
    front.z_near = 0.5;
    front.z_far = 20;
    CameraNode plan;
    plan.name = "plan";
    plan.orthographic = true;
    plan.half_width = 3;
    plan.half_height = 2;
    plan.z_near = 1;
    plan.z_far = 9;
    scene_.cameras = {front, plan};
  }

  View view(GltfCamera camera, Extent picture) { return make_view({camera, {}, 0}, scene_, picture); }

  glm::vec3 project(const View& view, const glm::vec3& point) {
    const glm::vec4 clip = view.clip_from_view * view.view_from_world * glm::vec4(point, 1);
    return glm::vec3(clip) / clip.w;
  }

  Scene scene_;
};

TEST_F(GltfView, IsFoundByIndexAndByName) {
  EXPECT_EQ(view({0}, {8, 4}).eye, glm::vec3(0, 0, 5));
  EXPECT_EQ(view({"front"}, {8, 4}).clip_from_view, view({0}, {8, 4}).clip_from_view);
  EXPECT_TRUE(view({"plan"}, {8, 4}).orthographic);
}

TEST_F(GltfView, KeepsTheFilesPlanes) {
  const View v = view({0}, {8, 4});
  EXPECT_NEAR(project(v, {0, 0, 4.5f}).z, 1, 1e-6);
  EXPECT_NEAR(project(v, {0, 0, -15}).z, 0, 1e-6);
}

TEST_F(GltfView, AWiderPictureKeepsYfovANarrowerOneKeepsXfov) {
  const float tangent = std::tan(0.35f);
  for (const Extent picture : {Extent{8, 4}, Extent{16, 4}})
    EXPECT_NEAR(project(view({0}, picture), {0, tangent, 4}).y, 1, 1e-6);
  for (const Extent picture : {Extent{8, 4}, Extent{4, 4}, Extent{2, 4}})
    EXPECT_NEAR(project(view({0}, picture), {2 * tangent, 0, 4}).x, 1, 1e-6);
}

TEST_F(GltfView, WithoutAnAspectOfItsOwnYfovIsKept) {
  scene_.cameras[0].aspect_ratio.reset();
  for (const Extent picture : {Extent{8, 4}, Extent{2, 4}})
    EXPECT_NEAR(project(view({0}, picture), {0, std::tan(0.35f), 4}).y, 1, 1e-6);
}

TEST_F(GltfView, AnOrthographicFrameIsSeenWhole) {
  const View wide = view({1}, {8, 2}), narrow = view({1}, {2, 8});
  EXPECT_NEAR(project(wide, {0, 2, -1}).y, 1, 1e-6);
  EXPECT_NEAR(project(wide, {8, 0, -1}).x, 1, 1e-6);
  EXPECT_NEAR(project(narrow, {3, 0, -9}).x, 1, 1e-6);
  EXPECT_NEAR(project(narrow, {0, 12, -9}).z, 0, 1e-6);
}

TEST_F(GltfView, ScaleOfTheNodeDoesNotCount) {
  const View expected = view({0}, {8, 4});
  scene_.cameras[0].world_from_view = glm::scale(scene_.cameras[0].world_from_view, glm::vec3(3, 0.1f, 7));
  const View actual = view({0}, {8, 4});
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(actual.view_from_world[i][j], expected.view_from_world[i][j], 1e-6);
}

TEST_F(GltfView, MissingCamerasAndFlatNodesAreErrors) {
  const auto expect_error = [&](GltfCamera camera, const char* words) {
    try {
      view(camera, {8, 4});
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
      EXPECT_EQ(error.pointer, "/camera/gltf");
      EXPECT_THAT(error.message, testing::HasSubstr(words));
    }
  };
  expect_error({2}, "no camera 2");
  expect_error({-1}, "no camera -1");
  expect_error({"back"}, "\"back\"");
  scene_.cameras[0].world_from_view = glm::mat4(0);
  expect_error({0}, "scale of zero");
}

// u = cx + fx x / z, v = cy - fy y / z of a camera that looks along -Z.
TEST(Framing, ACalibratedCameraPutsPointsWhereItsMatrixDoes) {
  IntrinsicsCamera camera;
  camera.focal_px = {700, 650};
  camera.principal_px = {300, 260};
  camera.picture_px = {640, 480};
  camera.translation = {0.5f, -1, 4};
  for (const Extent picture : {Extent{640, 480}, Extent{320, 240}}) {
    const View view = make_view({camera, {}, 0}, Scene{}, picture);
    for (const glm::vec3 in_camera :
         {glm::vec3(0, 0, -2), glm::vec3(0.7f, -0.4f, -3), glm::vec3(-1, 0.5f, -5)}) {
      const glm::vec4 clip =
          view.clip_from_view * view.view_from_world * glm::vec4(in_camera + camera.translation, 1);
      const double u = (double(clip.x / clip.w) * 0.5 + 0.5) * 640,
                   v = (0.5 - double(clip.y / clip.w) * 0.5) * 480;
      EXPECT_NEAR(u, 300 + 700 * in_camera.x / -in_camera.z, 1e-2);
      EXPECT_NEAR(v, 260 - 650 * in_camera.y / -in_camera.z, 1e-2);
    }
  }
}

}  // namespace
}  // namespace furnace
