// What moves while the shutter is open, against closed forms and against the mean of many instants.
#include <algorithm>

#include "renderer/frame/cryptomatte.hpp"
#include "renderer/scene/sequence.hpp"
#include "renderer/scene/shutter.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/frame/moving_quad.hpp"

namespace furnace {
namespace {

constexpr double kShutterS = 0.5;  // 8 px of the quad's way
constexpr int kMiddleRow = 32;

class MotionBlurGlTest : public ClosedFormGlTest {
 protected:
  // Of a pixel's middle, m.
  static double place(int x) { return (x + 0.5) / kPxPerMetre - 2; }
  // The share of the shutter for which a metre of quad that moves so far covers x.
  static double ramp(double x, double way_m) {
    return std::clamp((0.5 + way_m / 2 - std::abs(x)) / way_m, 0.0, 1.0);
  }
  // The ramp as a pixel sees it: over its width, in two samples a quarter of a pixel off its middle.
  static double seen_ramp(int x) {
    constexpr int kSteps = 200;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (const double off : {-0.25, 0.25})
        sum += ramp(place(x) + ((i + 0.5) / kSteps - 0.5 + off) / kPxPerMetre, kShutterS) / (2 * kSteps);
    }
    return sum;
  }
  // Of the middle row.
  static double rms_error(const Film& film) {
    double sum = 0;
    for (int x = 0; x < 64; ++x) sum += std::pow(pixel(film, x, kMiddleRow).g - seen_ramp(x), 2);
    return std::sqrt(sum / 64);
  }
  static double difference(const Film& a, const Film& b) {
    double most = 0;
    const auto x = a.image.samples<float>(), y = b.image.samples<float>();
    for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, double(std::abs(x[i] - y[i])));
    return most;
  }
  static bool has_note(const Film& film, std::string_view code) {
    return std::any_of(film.notes.begin(), film.notes.end(),
                       [&](const Note& note) { return note.code == code; });
  }
};

// Each sub-frame is a step of 1 / samples, and its four samples are two steps of half a pixel.
TEST_F(MotionBlurGlTest, ConstantSpeedIsALinearRamp) {
  for (const int samples : {16, 64}) {
    const Film film = render(moving_spec(moving_quad(), samples, kShutterS));
    EXPECT_TRUE(film.notes.empty());
    for (int x = 0; x < 64; ++x) {
      const double expected = ramp(place(x), kShutterS);
      EXPECT_NEAR(pixel(film, x, kMiddleRow).g, expected, 1.0 / samples + 0.25 / 8) << samples << " " << x;
    }
    // What is lost before is gained behind.
    double sum = 0;
    for (int x = 0; x < 64; ++x) sum += pixel(film, x, kMiddleRow).g;
    EXPECT_NEAR(sum, kPxPerMetre, 0.05);
  }
}

TEST_F(MotionBlurGlTest, MoreSubFramesOnlyConverge) {
  double before = 1;
  for (const int samples : {1, 4, 16, 64}) {
    const double error = rms_error(render(moving_spec(moving_quad(), samples, kShutterS)));
    EXPECT_LT(error, before) << samples;
    EXPECT_LT(error, 0.6 / samples) << samples;  // measured: 0.14, 0.12, 0.13, 0.44
    before = error;
  }
  // Beyond kMostMoments sub-frames share moments, equally.
  EXPECT_LT(rms_error(render(moving_spec(moving_quad(), 100, kShutterS))), before);
}

TEST_F(MotionBlurGlTest, NodesMorphTargetsAndJointsLeaveOneTrace) {
  const Film node = render(moving_spec(moving_quad(), 8, kShutterS));
  EXPECT_LT(difference(node, render(moving_spec(morphing_quad(), 8, kShutterS))), 1e-6);
  EXPECT_LT(difference(node, render(moving_spec(skinned_quad(), 8, kShutterS))), 1e-6);
}

// A quarter turn of a square: where a circle leaves it, it is seen for as long as the circle is in it.
TEST_F(MotionBlurGlTest, RotationBlursAlongCircles) {
  GltfBuilder builder = quad_builder();
  const float half = std::sqrt(0.5f);
  animate(builder, {{"node", 0}, {"path", "rotation"}}, "VEC4", {0, 0, 0, 1, 0, 0, half, half});
  const Film film = render(moving_spec(builder, 64, 2));
  for (int x = 0; x < 64; ++x) {
    const double r = std::hypot(place(x), place(kMiddleRow));
    const double outside = r > 0.5 ? std::acos(std::min(0.5 / r, 1.0)) : 0;
    const double expected = r < std::sqrt(0.5) ? 1 - 2 * outside / (kPi / 2) : 0;
    // At both ends the share changes steeply within a pixel.
    const double edge_px = kPxPerMetre * std::min(std::abs(r - 0.5), std::abs(r - std::sqrt(0.5)));
    if (edge_px > 0.75) {
      EXPECT_NEAR(pixel(film, x, kMiddleRow).g, expected, 0.04) << x;
    }
  }
}

TEST_F(MotionBlurGlTest, WhatAnimationsSayOfMaterialsLightsAndVisibilityIsAveraged) {
  GltfBuilder colored = quad_builder();
  animate(colored, pointer_target("/materials/0/pbrMetallicRoughness/baseColorFactor"), "VEC4",
          {0, 1, 0.5f, 1, 1, 0, 0.5f, 1});
  EXPECT_LT(glm::distance(pixel(render(moving_spec(colored, 8, 2)), 32, 32), glm::vec3(0.5f)), 1e-5f);

  GltfBuilder lit = quad_builder();
  lit.json["materials"][0].erase("extensions");
  lit.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}}};
  lit.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  animate(lit, pointer_target("/extensions/KHR_lights_punctual/lights/0/intensity"), "SCALAR", {0, 4});
  RenderSpec lit_spec = moving_spec(lit, 8, 2);
  const float blurred = pixel(render(lit_spec), 32, 32).g;
  lit_spec.camera.motion.shutter_s = 0;
  EXPECT_GT(blurred, 0.1f);
  EXPECT_NEAR(blurred, pixel(render(lit_spec), 32, 32).g, 1e-5f);

  GltfBuilder hidden =
      quad_builder({{"name", "quad"}, {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}});
  const int input = hidden.add_accessor<float>("SCALAR", {0, 1});
  const int output = hidden.add_accessor<float>("SCALAR", {1, 0});
  hidden.add(
      "animations",
      {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", "STEP"}}}},
       {"channels",
        {{{"sampler", 0}, {"target", pointer_target("/nodes/0/extensions/KHR_node_visibility/visible")}}}}});
  RenderSpec hidden_spec = moving_spec(hidden, 8, 2);
  hidden_spec.output.layers = {FilmLayer::kCoverage, FilmLayer::kCryptoObject};
  const Film film = render(hidden_spec);
  EXPECT_NEAR(pixel(film, 32, 32).g, 0.5f, 1e-6f);
  ASSERT_EQ(film.layers.size(), 4u);
  const std::size_t at = 32 * 64 + 32;
  EXPECT_NEAR(film.layers[0].image.samples<float>()[at], 0.5f, 1e-6f);
  EXPECT_EQ(film.layers[1].image.samples<float>()[4 * at], matte_id("quad"));
  EXPECT_NEAR(film.layers[1].image.samples<float>()[4 * at + 1], 0.5f, 1e-6f);
}

// A camera that goes left sees what stands still go right.
TEST_F(MotionBlurGlTest, CamerasOfTheModelMove) {
  GltfBuilder builder = quad_builder();
  builder.add("cameras", {{"type", "orthographic"},
                          {"orthographic", {{"xmag", 2}, {"ymag", 2}, {"znear", 0.1}, {"zfar", 10}}}});
  builder.add("nodes", {{"camera", 0}});
  builder.add("scenes", {{"nodes", {0, 1}}});
  animate(builder, {{"node", 1}, {"path", "translation"}}, "VEC3", {1, 0, 3, -1, 0, 3});
  RenderSpec spec = moving_spec(builder, 8, kShutterS);
  spec.camera.view = GltfCamera{0};
  EXPECT_LT(difference(render(spec), render(moving_spec(moving_quad(), 8, kShutterS))), 1e-5);
}

// So does one of a turntable, whose frames are told how it turns.
TEST_F(MotionBlurGlTest, ATurningCameraBlursAsATurningScene) {
  GltfBuilder turning = quad_builder();
  const float half = std::sqrt(0.5f);
  animate(turning, {{"node", 0}, {"path", "rotation"}}, "VEC4", {0, half, 0, half, 0, -half, 0, half});
  turning.json["materials"][0]["doubleSided"] = true;
  RenderSpec spec = moving_spec(turning, 16, 1);
  const Film scene = render(spec);

  // Half a turn to the left in two seconds, as a camera that goes as far to the right.
  spec.output.sequence.emplace().frames = 10;
  spec.output.sequence->frames_per_second = 5;
  spec.output.sequence->turntable_rad = kPi;
  spec.scene.animations.clear();
  const RenderSpec frame = frames_of(spec, 10).front();
  EXPECT_NEAR(frame.camera.motion.turn_rad_per_s, kPi / 2, 1e-12);
  GltfBuilder still = quad_builder();
  still.json["materials"][0]["doubleSided"] = true;
  RenderSpec seen = frame;
  seen.scene.model = std::make_shared<const ModelBundle>(still.bundle());
  EXPECT_LT(difference(scene, render(seen)), 1e-4);
  seen.camera.motion.shutter_s = 0;
  EXPECT_GT(difference(scene, render(seen)), 0.2);
}

TEST_F(MotionBlurGlTest, WhatStandsStillStaysAsItIs) {
  GltfBuilder builder = quad_builder();
  animate(builder, {{"node", 0}, {"path", "translation"}}, "VEC3", {0.3f, 0, 0, 0.3f, 0, 0});
  RenderSpec spec = moving_spec(builder, 16, kShutterS);
  spec.camera.view = OrbitCamera{};
  spec.camera.depth_of_field.emplace().aperture_diameter_m = 0.1;
  spec.environment.map = BuiltinName{"studio"};
  const Film blurred = render(spec);
  spec.camera.motion.shutter_s = 0;
  EXPECT_EQ(blurred.image.pixels, render(spec).image.pixels);
}

TEST_F(MotionBlurGlTest, ASingleSampleSeesTheMiddleAndSaysSo) {
  RenderSpec spec = moving_spec(moving_quad(), 1, kShutterS);
  const Film film = render(spec);
  EXPECT_TRUE(has_note(film, "motion-blur-needs-samples"));
  spec.camera.motion.shutter_s = 0;
  EXPECT_EQ(film.image.pixels, render(spec).image.pixels);
}

// Shadows of lights, of the environment and on the ground, through a lens: the mean of many instants, each drawn alone.
TEST_F(MotionBlurGlTest, IsTheMeanOfInstants) {
  GltfBuilder builder = quad_builder({{"rotation", {0, 0.38268343, 0, 0.92387953}}});
  builder.json["materials"][0].erase("extensions");
  builder.json["materials"][0]["doubleSided"] = true;
  animate(builder, {{"node", 0}, {"path", "translation"}}, "VEC3", {-0.4f, 0.5f, 0, 0.4f, 0.9f, 0});
  constexpr int kInstants = 8;
  RenderSpec spec = moving_spec(builder, kInstants, 2);
  spec.output.width = spec.output.height = 48;
  spec.environment.visibility = EnvironmentVisibility::kOn;
  spec.environment.map = BuiltinName{"clear-sky"};
  spec.environment.ground = GroundSpec{};
  spec.environment.ground->level_m = 0;
  spec.camera.view = LookAtCamera{{1.5f, 1.5f, 3}, {0, 0.4f, 0}};
  spec.camera.depth_of_field.emplace().aperture_diameter_m = 0.05;
  spec.camera.depth_of_field->focus_distance_m = 3;
  NodeSpec floor = node("plane", "gold", {0, 0.05f, 0});
  floor.scale = {1, 1, 0.6f};
  spec.scene.nodes = {floor};
  const Film blurred = render(spec);

  RenderSpec still = spec;
  still.camera.motion.shutter_s = 0;
  std::vector<double> mean(blurred.image.samples<float>().size(), 0);
  for (const double offset_s : moment_offsets_s(kInstants, kInstants, 2)) {
    still.scene = scene_at(spec.scene, offset_s);
    const Film instant = render(still);
    const auto samples = instant.image.samples<float>();
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += double(samples[i]) / kInstants;
  }
  double squares = 0, light = 0, off_still = 0;
  still.scene = spec.scene;
  const Film middle = render(still);
  for (std::size_t i = 0; i < mean.size(); ++i) {
    squares += std::pow(double(blurred.image.samples<float>()[i]) - mean[i], 2);
    off_still += std::pow(double(middle.image.samples<float>()[i]) - mean[i], 2);
    light += mean[i] * mean[i];
  }
  // Each instant has all places of pixel, lens and lights, the blurred picture one of each.
  EXPECT_LT(std::sqrt(squares / light), 0.04);
  EXPECT_GT(std::sqrt(off_still), 3 * std::sqrt(squares));
}

// What moves behind glass moves behind it, and glass that moves shows what is behind it now.
TEST_F(MotionBlurGlTest, GlassShowsWhatStandsBehindItAtTheTime) {
  GltfBuilder builder = moving_quad();
  RenderSpec spec = moving_spec(builder, 16, kShutterS);
  MaterialOverride glass;
  glass.transmission = 1.f;
  glass.metallic = 0.f;
  glass.perceptual_roughness = 0.f;
  glass.ior = 1.f;
  spec.scene.materials["glass"] = glass;
  NodeSpec pane = node("plane", "glass", {0, 0, 1}, 3);
  pane.rotation = glm::angleAxis(glm::radians(90.f), glm::vec3(1, 0, 0));
  spec.scene.nodes = {pane};
  const Film film = render(spec);
  for (int x = 16; x < 48; ++x)
    EXPECT_NEAR(pixel(film, x, kMiddleRow).g, ramp(place(x), kShutterS), 1.0 / 16 + 0.06) << x;
}

TEST_F(MotionBlurGlTest, TheSameRequestGivesTheSamePixels) {
  const RenderSpec spec = moving_spec(skinned_quad(), 16, kShutterS);
  const Film first = render(spec), second = render(spec);
  EXPECT_EQ(first.image.pixels, second.image.pixels);
  EXPECT_TRUE(second.times.decode_hit);
  EXPECT_TRUE(second.times.upload_hit);
}

TEST_F(MotionBlurGlTest, TilesLeaveNoTrace) {
  static WorkerPool pool(2);
  RendererConfig config;
  config.gl = {"software", gl::Determinism::kExact};
  config.max_tile_px = 24;
  Renderer tiled(config, pool, decode::in_process_decoder());
  RenderSpec spec = moving_spec(skinned_quad(), 8, kShutterS);
  spec.environment.map = BuiltinName{"studio"};
  spec.scene.nodes = {node("sphere", "gold", {0.3f, 0.2f, 0.6f}, 0.8f)};
  EXPECT_LT(difference(render(spec), tiled.render(spec, Deadline())), 1e-4);
}

}  // namespace
}  // namespace furnace
