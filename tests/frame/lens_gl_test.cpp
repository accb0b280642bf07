// Several sub-frames of whole pictures: the profile of an edge under each pixel filter, and circles of confusion.
#include <cmath>

#include "renderer/frame/pixel_filter.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

class LensGlTest : public ClosedFormGlTest {
 protected:
  static constexpr int kSide = 32;

  // An unlit white half plane, seen from above under a right angle: its edge lies at `edge_px`.
  static RenderSpec half_plane(double edge_px) {
    MaterialOverride white;
    white.base_color = glm::vec4(1);
    white.unlit = true;
    RenderSpec spec = spec_of("plane", white, glm::vec3(0));
    spec.scene.nodes[0].scale = glm::vec3(8, 1, 8);
    spec.scene.nodes[0].translation = glm::vec3(4 + 2 * edge_px / kSide - 1, 0, 0);
    spec.camera.view = LookAtCamera{{0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 2 * std::atan(1.0)};
    spec.environment.background = ColorBackground{};
    spec.output.width = spec.output.height = kSide;
    return spec;
  }
  // The filter's share below `x`, as the four samples of each sub-frame see it: a quarter of a pixel to both sides.
  static double profile(const PixelFilter& filter, double x) {
    constexpr int kSteps = 20'000;
    double below = 0, all = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double at = filter.radius_px * (2 * (i + 0.5) / kSteps - 1);
      all += filter_value(filter, at);
      if (at < x - 0.25) below += filter_value(filter, at) / 2;
      if (at < x + 0.25) below += filter_value(filter, at) / 2;
    }
    return below / all;
  }
  static double largest_difference(const Film& a, const Film& b) {
    const auto left = a.image.samples<float>(), right = b.image.samples<float>();
    EXPECT_EQ(left.size(), right.size());
    double largest = 0;
    for (std::size_t i = 0; i < left.size(); ++i)
      largest = std::max(largest, std::abs(double(left[i]) - double(right[i])));
    return largest;
  }
};

TEST_F(LensGlTest, AnEdgeHasTheFiltersProfile) {
  constexpr double kEdge = 15.3;
  RenderSpec spec = half_plane(kEdge);
  spec.output.samples = 1024;
  const PixelFilter filters[] = {{PixelFilterKind::kBox, 0.5},
                                 {PixelFilterKind::kGaussian, 1.5},
                                 {PixelFilterKind::kBlackmanHarris, 2},
                                 {PixelFilterKind::kMitchell, 2}};
  for (const PixelFilter& filter : filters) {
    spec.output.pixel_filter = filter;
    const Film film = render(spec);
    for (int x = 11; x < 20; ++x) {
      // What a thousand places of the sequence leave, and 0 where the filter overshoots to below.
      const double expected = std::max(profile(filter, x + 0.5 - kEdge), 0.0);
      EXPECT_NEAR(pixel(film, x, 16).g, expected, 6e-3) << int(filter.kind) << " " << x;
    }
  }
}

TEST_F(LensGlTest, AnEvenPictureStaysEvenUnderNegativeLobes) {
  RenderSpec spec = half_plane(-20);
  spec.output.pixel_filter = {PixelFilterKind::kMitchell, 2};
  for (const int samples : {2, 5, 64}) {
    spec.output.samples = samples;
    const Film film = render(spec);
    for (const float value : film.image.samples<float>()) ASSERT_NEAR(value, 1, 1e-6) << samples;
  }
}

// Beside what is a thousand times as bright as white no pixel is darker than beside white, and none is black; what white does
// to its neighbours stays (AnEdgeHasTheFiltersProfile).
TEST_F(LensGlTest, NegativeLobesLeaveNoBlackBesideSuns) {
  constexpr float kDark = 0.02f;
  RenderSpec spec = half_plane(14.9);
  spec.environment.background = ColorBackground{glm::vec3(kDark)};
  spec.output.pixel_filter = {PixelFilterKind::kMitchell, 2};
  spec.output.samples = 256;
  const auto beside = [&](float radiance, double exposure_ev) {
    spec.scene.materials["m"].base_color = glm::vec4(glm::vec3(0), 1);
    spec.scene.materials["m"].emissive = glm::vec3(radiance);
    spec.scene.materials["m"].unlit = false;
    spec.camera.exposure_ev = exposure_ev;
    return render(spec);
  };
  const Film white = beside(1, 0), sun = beside(1000, 0);
  int undershot = 0;
  for (int x = 0; x < 14; ++x) {
    const float at_white = pixel(white, x, 16).g, at_sun = pixel(sun, x, 16).g;
    EXPECT_GE(at_sun, at_white - 1e-6f) << x;
    EXPECT_GT(at_sun, 0.9f * kDark) << x;
    undershot += at_white < 0.9f * kDark;
  }
  EXPECT_GE(undershot, 1);
  // The bright side itself is as it was, whatever is white.
  for (int x = 18; x < 32; ++x) EXPECT_NEAR(pixel(sun, x, 16).g / 1000, pixel(white, x, 16).g, 2e-2) << x;
  for (int x = 20; x < 32; ++x) EXPECT_NEAR(pixel(beside(1000, 0), x, 16).g, 1000, 1e-2);
  // White is what is exposed to it: ten stops down the sun is white.
  const Film dim = beside(1000, -10);
  EXPECT_LT(pixel(dim, 13, 16).g, 0.9f * kDark);
}

TEST_F(LensGlTest, ASingleSubFrameKnowsNoFilter) {
  RenderSpec spec = half_plane(15.3);
  const Film box = render(spec);
  spec.output.pixel_filter = {PixelFilterKind::kGaussian, 3};
  EXPECT_EQ(render(spec).image.pixels, box.image.pixels);
}

// A small bright ball 4 m away of a lens of 0.2 m that is focused at 2 m: its image is a disc of diameter
// |1 / 2 - 1 / 4| * 0.2 m / (2 tan) * height.
TEST_F(LensGlTest, TheCircleOfConfusionIsThatOfAThinLens) {
  constexpr double kTangent = 0.25, kBallRadius = 0.01;
  MaterialOverride bright;
  bright.base_color = glm::vec4(0, 0, 0, 1);
  bright.emissive = glm::vec3(100);
  RenderSpec spec = spec_of("sphere", bright, glm::vec3(0));
  spec.scene.nodes[0].scale = glm::vec3(2 * kBallRadius);
  spec.environment.background = ColorBackground{};
  spec.camera.view = LookAtCamera{{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(kTangent)};
  spec.output.width = spec.output.height = 128;
  spec.output.samples = 1024;
  for (const int blades : {0, 4}) {
    DepthOfField& lens = spec.camera.depth_of_field.emplace();
    lens.aperture_diameter_m = 0.2;
    lens.focus_distance_m = 2;
    lens.blades = blades;
    const Film film = render(spec);
    double sum = 0, farthest = 0;
    glm::dvec2 mean(0), square(0);
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) {
        const auto value = double(pixel(film, x, y).g);
        const glm::dvec2 at(x - 63.5, y - 63.5);
        sum += value;
        mean += value * at;
        square += value * at * at;
        if (value > 0) farthest = std::max(farthest, glm::length(at));
      }
    }
    const double px_per_tangent = 128 / (2 * kTangent);
    const double radius_px = 0.1 * (1 / 2.0 - 1 / 4.0) * px_per_tangent;
    const double ball_px = kBallRadius / 4 * px_per_tangent;
    // Variances: of the lens, of the ball's disc, of the box of a pixel and of its four samples.
    const double of_lens = blades == 0 ? 0.25 : 1.0 / 6;
    const double expected = of_lens * radius_px * radius_px + ball_px * ball_px / 4 + 1 / 12.0 + 1 / 16.0;
    EXPECT_LT(glm::length(mean / sum), 0.1);
    EXPECT_NEAR(square.x / sum, expected, 0.03 * expected) << blades;
    EXPECT_NEAR(square.y / sum, expected, 0.03 * expected) << blades;
    EXPECT_NEAR(farthest, radius_px + ball_px, 1.2) << blades;
    EXPECT_NEAR(sum, 100 * kPi * ball_px * ball_px, 0.05 * sum) << blades;  // the mesh is a polyhedron
  }
}

TEST_F(LensGlTest, ThePlaneOfFocusIsSharp) {
  RenderSpec spec = half_plane(15.3);
  spec.output.samples = 16;
  const Film pinhole = render(spec);
  DepthOfField& lens = spec.camera.depth_of_field.emplace();
  lens.aperture_diameter_m = 0.3;
  // Rounding may move an edge past a sample here and there.
  EXPECT_LE(largest_difference(render(spec), pinhole), 1.01 / 64);
  lens.focus_distance_m = 2;
  EXPECT_GT(largest_difference(render(spec), pinhole), 0.1);
}

TEST_F(LensGlTest, OneSampleIsAPinholeAndSaysSo) {
  RenderSpec spec = half_plane(15.3);
  const Film pinhole = render(spec);
  EXPECT_TRUE(pinhole.notes.empty());
  spec.camera.depth_of_field.emplace().focus_distance_m = 2;
  const Film film = render(spec);
  EXPECT_EQ(film.image.pixels, pinhole.image.pixels);
  ASSERT_EQ(film.notes.size(), 1u);
  EXPECT_EQ(film.notes[0].code, "depth-of-field-needs-samples");
  EXPECT_EQ(film.notes[0].pointer, "/camera/depthOfField");
}

}  // namespace
}  // namespace furnace
