// The plan is a pure function; the uniform block is checked by projecting points.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "renderer/frame/frame_uniform.hpp"
#include "renderer/frame/sky_plan.hpp"
#include "renderer/scene/transform.hpp"

namespace furnace {
namespace {

TEST(FramePlan, TilesCoverThePictureOnce) {
  RenderSpec spec;
  spec.output.width = 250;
  spec.output.height = 130;
  const FramePlan plan = plan_frame(spec, 64);
  std::vector<int> covered(250 * 130);
  for (const Tile& tile : plan.tiles) {
    EXPECT_LE(tile.size.width, plan.tile_size.width);
    EXPECT_LE(tile.size.height, plan.tile_size.height);
    for (int y = tile.y; y < tile.y + tile.size.height; ++y) {
      for (int x = tile.x; x < tile.x + tile.size.width; ++x) ++covered[std::size_t(y * 250 + x)];
    }
  }
  EXPECT_EQ(std::set<int>(covered.begin(), covered.end()), std::set<int>{1});
}

TEST(FramePlan, EachSourceOfLayersIsDrawnOnce) {
  RenderSpec spec;
  EXPECT_TRUE(plan_frame(spec, 1024).layers.sources.empty());
  EXPECT_TRUE(plan_frame(spec, 1024).layers.needs_picture());
  spec.output.layers = {FilmLayer::kDepth,     FilmLayer::kPosition, FilmLayer::kRoughness,
                        FilmLayer::kOcclusion, FilmLayer::kCoverage, FilmLayer::kCryptoObject};
  spec.output.shown = FilmLayer::kViewNormal;
  const LayerPlan layers = plan_frame(spec, 1024).layers;
  EXPECT_EQ(layers.sources, (std::vector{FilmLayer::kPosition, FilmLayer::kRoughness, FilmLayer::kNormal}));
  EXPECT_TRUE(layers.any_matte());
  EXPECT_FALSE(layers.needs_picture());
  EXPECT_FALSE(layers.shows_radiance());
  spec.output.bloom.emplace();
  EXPECT_FALSE(plan_frame(spec, 1024).bloom) << "what does not glow needs no glow";
  spec.output.shown = FilmLayer::kGlow;
  EXPECT_TRUE(plan_frame(spec, 1024).bloom);
  EXPECT_TRUE(plan_frame(spec, 1024).layers.needs_picture());
}

TEST(FramePlan, ManyLayersAreDrawnInSmallerTiles) {
  RenderSpec spec;
  EXPECT_EQ(plan_frame(spec, 1024).tile_size, (Extent{1024, 1024}));
  for (const FilmLayerRow& row : kFilmLayers) spec.output.layers.push_back(row.layer);
  EXPECT_EQ(plan_frame(spec, 1024).tile_size, (Extent{512, 512}));
  EXPECT_EQ(plan_frame(spec, 64).tile_size, (Extent{64, 64}));
}

TEST(FramePlan, SubFramesLieBalancedWithinThePixel) {
  RenderSpec spec;
  for (const int count : {1, 2, 3, 4, 5, 9, 16, 60, 64, 256, 1000}) {
    spec.output.samples = count;
    const FramePlan plan = plan_frame(spec, 1024);
    ASSERT_EQ(plan.jitter_px.size(), std::size_t(count));
    glm::dvec2 mean(0), variance(0);
    for (const glm::vec2& jitter : plan.jitter_px) {
      ASSERT_GE(std::min(jitter.x, jitter.y), -0.5f);
      ASSERT_LT(std::max(jitter.x, jitter.y), 0.5f);
      mean += glm::dvec2(jitter) / double(count);
      variance += glm::dvec2(jitter) * glm::dvec2(jitter) / double(count);
    }
    EXPECT_LT(glm::length(mean), 1e-6) << count;
    // Of even places 1 / 12; few of them have less.
    if (count < 4) continue;
    EXPECT_NEAR(variance.x, 1.0 / 12, 0.2 / count) << count;
    EXPECT_NEAR(variance.y, 1.0 / 12, 0.2 / count) << count;
  }
}

TEST(SkyViews, AreMoreWhereMapsCostLittleAndNeverFewerInAll) {
  for (const std::size_t triangles : {12u, 20'000u, 1'000'000u}) {
    int all_before = 0;
    for (const int subframes : {1, 4, 16, 64, 256}) {
      const int views = sky_views_wanted(subframes, triangles);
      EXPECT_GE(views, 8);
      EXPECT_LE(views, int(gpu::MOST_SKY_VIEWS));
      EXPECT_GE(views * subframes, all_before) << triangles << " " << subframes;
      all_before = views * subframes;
    }
  }
  EXPECT_GT(sky_views_wanted(16, 12), sky_views_wanted(16, 20'000));
  EXPECT_GT(sky_views_wanted(16, 20'000), sky_views_wanted(16, 1'000'000));
}

TEST(FramePlan, ABackgroundColourIsNotExposed) {
  RenderSpec spec;
  spec.environment.background = ColorBackground{{0.5f, 0.25f, 1}};
  spec.camera.exposure_ev = 2;
  const FramePlan plan = plan_frame(spec, 1024);
  EXPECT_EQ(plan.background_top * float(plan.exposure), glm::vec4(0.5f, 0.25f, 1, 4));
}

class FrameUniformTest : public testing::Test {
 protected:
  FrameUniformTest() {
    spec_.output.width = 300;
    spec_.output.height = 200;
    spec_.output.samples = 4;
    plan_ = plan_frame(spec_, 1024);
    view_.view_from_world = look_at({3, 2, 5}, {0, 1, 0}, {0, 1, 0});
    view_.clip_from_view = perspective_reversed(0.7, 1.5, 0.1, 100);
    view_.eye = {3, 2, 5};
    environment_.sky.texels = make_image({4, 2}, 4, SampleType::kFloat16, ColorSpace::kLinear);
    environment_.atlas.texels = make_image({8, 8}, 4, SampleType::kFloat16, ColorSpace::kLinear);
    environment_.atlas.level_roughness = {0.1, 1};
    environment_.atlas.level_tiles = {{1, 1, 2}, {5, 1, 2}};
    environment_.atlas.irradiance_tile = {1, 5, 2};
    // Lives as long as the test; owned by it.
    scene_.environment = std::shared_ptr<const PreparedEnvironment>(std::shared_ptr<void>(), &environment_);
    scene_.background = std::shared_ptr<const PreparedSky>(std::shared_ptr<void>(), &environment_.sky);
  }
  glm::vec2 pixel_of(const glm::mat4& clip_from_world, const glm::vec3& world) const {
    const glm::vec4 clip = clip_from_world * glm::vec4(world, 1);
    return {(clip.x / clip.w * 0.5f + 0.5f) * 300, (0.5f - clip.y / clip.w * 0.5f) * 200};
  }
  RenderSpec spec_;
  FramePlan plan_;
  View view_;
  PreparedEnvironment environment_;
  PreparedScene scene_;
};

TEST_F(FrameUniformTest, JitterMovesThePictureByItsPixels) {
  const glm::vec3 point(0.4f, 0.7f, -1);
  const glm::vec2 still =
      pixel_of(pack_frame(plan_, view_, scene_, nullptr, plan_.tiles[0], 0).clip_from_world, point);
  for (std::size_t i = 1; i < 4; ++i) {
    const glm::vec2 moved =
        pixel_of(pack_frame(plan_, view_, scene_, nullptr, plan_.tiles[0], i).clip_from_world, point);
    EXPECT_NEAR(moved.x - still.x, plan_.jitter_px[i].x - plan_.jitter_px[0].x, 1e-3);
    EXPECT_NEAR(moved.y - still.y, plan_.jitter_px[i].y - plan_.jitter_px[0].y, 1e-3);
  }
}

// A tile's clip space and rays are the picture's, cut out.
TEST_F(FrameUniformTest, TilesAreCutFromThePicture) {
  const gpu::FrameBlock whole = pack_frame(plan_, view_, scene_, nullptr, plan_.tiles[0], 1);
  const Tile tile{120, 70, {64, 32}};
  const gpu::FrameBlock cut = pack_frame(plan_, view_, scene_, nullptr, tile, 1);
  const glm::vec3 point(0.1f, 0.9f, 0.3f);
  const glm::vec2 there = pixel_of(whole.clip_from_world, point);
  const glm::vec4 clip = cut.clip_from_world * glm::vec4(point, 1);
  EXPECT_NEAR((clip.x / clip.w * 0.5f + 0.5f) * 64 + 120, there.x, 1e-3);
  EXPECT_NEAR((0.5f - clip.y / clip.w * 0.5f) * 32 + 70, there.y, 1e-3);
  const glm::vec3 ray = glm::mat3(cut.world_from_ray) * glm::vec3(clip.x / clip.w, clip.y / clip.w, 1);
  EXPECT_NEAR(glm::dot(glm::normalize(ray), glm::normalize(point - view_.eye)), 1, 1e-6);
  EXPECT_EQ(cut.background_lod, whole.background_lod);
}

TEST_F(FrameUniformTest, BackgroundRaysMeetTheSurfacesOfTheSamePixel) {
  for (std::size_t i = 0; i < 4; ++i) {
    const gpu::FrameBlock block = pack_frame(plan_, view_, scene_, nullptr, plan_.tiles[0], i);
    const glm::vec3 point(-0.6f, 1.4f, 0.5f);
    const glm::vec4 clip = block.clip_from_world * glm::vec4(point, 1);
    const glm::vec3 ray = glm::mat3(block.world_from_ray) * glm::vec3(clip.x / clip.w, clip.y / clip.w, 1);
    EXPECT_NEAR(glm::dot(glm::normalize(ray), glm::normalize(point - view_.eye)), 1, 1e-6);
  }
}

TEST_F(FrameUniformTest, TurningTheEnvironmentTurnsItAsAnObject) {
  plan_.environment_rotation_rad = kPi / 2;
  const gpu::FrameBlock block = pack_frame(plan_, view_, scene_, nullptr, plan_.tiles[0], 0);
  // Counter-clockwise seen from above: what stood at +X now stands at -Z.
  const glm::vec3 seen = glm::mat3(block.environment_from_world) * glm::vec3(0, 0, -1);
  EXPECT_NEAR(seen.x, 1, 1e-6);
  EXPECT_NEAR(seen.z, 0, 1e-6);
}

// Where a point of the ground is seen, its place in the ground's map comes out.
TEST_F(FrameUniformTest, TheGroundIsFoundAgain) {
  PreparedGround ground;
  ground.level_m = -0.25;
  ground.bounds = {glm::vec3(-1), glm::vec3(1)};
  scene_.ground = ground;
  const GroundRectangle map{{-2, -3}, {4, 1}};
  const glm::vec3 point(0.5f, -0.25f, -1);
  const glm::vec2 expected((0.5f + 2) / 6, (-1 + 3.f) / 4);
  for (const bool orthographic : {false, true}) {
    view_.orthographic = orthographic;
    if (orthographic) view_.clip_from_view = orthographic_reversed(3, 2, 0.1, 100);
    for (const Tile& tile : {plan_.tiles[0], Tile{60, 40, {180, 90}}}) {
      const gpu::FrameBlock block = pack_frame(plan_, view_, scene_, &map, tile, 2);
      const glm::vec4 clip = block.clip_from_world * glm::vec4(point, 1);
      const glm::vec3 at = glm::mat3(block.ground_from_ndc) * glm::vec3(clip.x / clip.w, clip.y / clip.w, 1);
      ASSERT_GT(at.z, 0);
      EXPECT_NEAR(at.x / at.z, expected.x, 1e-5);
      EXPECT_NEAR(at.y / at.z, expected.y, 1e-5);
    }
  }
}

TEST_F(FrameUniformTest, GainsUndoTheStoredScale) {
  environment_.sky.scale = 0.25;
  environment_.atlas.scale = 0.5;
  scene_.environment_intensity = 3;
  const gpu::FrameBlock block = pack_frame(plan_, view_, scene_, nullptr, plan_.tiles[0], 0);
  EXPECT_EQ(block.sky_gain, 12);
  EXPECT_EQ(block.atlas_gain, 6);
  EXPECT_EQ(block.level_count, 2u);
  EXPECT_EQ(block.level_tiles[1], glm::vec4(5, 1, 2, float(level_coordinate(1))));
}

}  // namespace
}  // namespace furnace
