#include "server/commands/render_options.hpp"

#include <gtest/gtest.h>

#include "renderer/assets/asset_resolver.hpp"
#include "renderer/base/error.hpp"
#include "api/render_request.hpp"
#include "server/commands/frame_files.hpp"

namespace furnace {
namespace {

RenderSpec parsed(const std::string& document) {
  FileAssets files({}, 0, 1);
  return api::parse_render_request(document, AssetResolver(files, {}, {}), {});
}

RenderOptions everything() {
  RenderOptions options;
  options.width = 64;
  options.height = 32;
  options.samples = 3;
  options.tone_map = "linear";
  options.format = "exr";
  options.exr_type = "float";
  options.exr_compression = "none";
  options.azimuth_degrees = 90;
  options.elevation_degrees = -10;
  options.exposure_ev = 1.5;
  options.aperture = 8;
  options.shutter_seconds = 0.01;
  options.iso = 400;
  options.f_stop = 1.4;
  options.focus_distance_m = 2.5;
  options.motion_blur_seconds = 0.02;
  options.bloom_intensity = 0.5;
  options.pixel_filter = "gaussian";
  options.white_balance_kelvin = 3200;
  options.white_balance_tint = -7;
  options.contrast = 1.25;
  options.saturation = 0.5;
  options.dither = true;
  options.rotation_degrees = 180;
  options.environment = "builtin:overcast";
  options.background = "#ff0080";
  options.sun = "keep";
  options.visibility = "on";
  options.shading_model = "phong";
  options.ground = true;
  options.layers = {"normal", "depth"};
  options.show = "albedo";
  return options;
}

TEST(RenderOptions, NoOptionIsTheEmptyDocument) {
  EXPECT_EQ(request_document({}, ""), "{}");
  EXPECT_EQ(request_document({}, "file:a \"b\".glb"), R"({"scene":{"model":"file:a \"b\".glb"}})");
}

TEST(RenderOptions, AVariantIsOfAModel) {
  RenderOptions options;
  options.variant = "midnight";
  EXPECT_EQ(request_document(options, "file:shoe.glb"),
            R"({"scene":{"model":"file:shoe.glb","variant":"midnight"}})");
  EXPECT_EQ(request_document(options, ""), "{}");
  RenderSpec spec;
  apply_options(options, parsed("{}"), spec);
  EXPECT_EQ(spec.scene.variant, "midnight");
}

TEST(RenderOptions, ASequenceOfAModel) {
  RenderOptions options;
  options.frames = 5;
  options.frames_per_second = 12.5;
  EXPECT_EQ(
      request_document(options, "file:a.glb"),
      R"({"scene":{"model":"file:a.glb","animation":{"index":0,"timeSeconds":0}},"output":{"sequence":{"frames":5,"framesPerSecond":12.5}}})");
  options.turntable_degrees = 180;
  options.container = "zip";
  EXPECT_EQ(
      request_document(options, "file:a.glb"),
      R"({"scene":{"model":"file:a.glb"},"output":{"sequence":{"frames":5,"framesPerSecond":12.5,"turntableDegrees":180,"container":"zip"}}})");
  RenderSpec spec;
  spec.output.sequence = Sequence{};
  spec.output.sequence->loops = 3;
  apply_options(options, parsed(request_document(options, "")), spec);
  EXPECT_EQ(spec.output.sequence->frames, 5);
  EXPECT_EQ(spec.output.sequence->frames_per_second, 12.5);
  EXPECT_NEAR(spec.output.sequence->turntable_rad, 3.14159265358979, 1e-12);
  EXPECT_EQ(spec.output.sequence->container, Sequence::Container::kArchive);
  EXPECT_EQ(spec.output.sequence->loops, 3);
  EXPECT_TRUE(spec.scene.animations.empty());
}

TEST(RenderOptions, AnAxisIsOfAModel) {
  RenderOptions options;
  options.up_axis = "z";
  EXPECT_EQ(request_document(options, "file:a.stl"), R"({"scene":{"model":"file:a.stl","upAxis":"z"}})");
  RenderSpec spec;
  apply_options(options, parsed("{}"), spec);
  EXPECT_EQ(spec.scene.up_axis, UpAxis::kZ);
}

TEST(RenderOptions, EveryOptionIsUnderstoodByTheApi) {
  const RenderSpec spec = parsed(request_document(everything(), ""));
  EXPECT_EQ(spec.output.width, 64);
  EXPECT_EQ(spec.output.height, 32);
  EXPECT_EQ(spec.output.samples, 3);
  EXPECT_EQ(spec.output.tone_map, ToneMap::kLinear);
  EXPECT_EQ(spec.output.format, OutputFormat::kExr);
  EXPECT_EQ(spec.output.exr_type, SampleType::kFloat32);
  EXPECT_EQ(spec.output.exr_compression, ExrCompression::kNone);
  EXPECT_NEAR(std::get<OrbitCamera>(spec.camera.view).azimuth_rad, 1.5707963,
              1e-6);  // single precision suffices
  EXPECT_EQ(spec.camera.exposure_ev, 1.5);
  EXPECT_NEAR(std::get<PhysicalExposure>(spec.camera.metering).ev100, 10.643856,
              1e-6);  // f/8, 1/100 s, ISO 400
  ASSERT_TRUE(spec.camera.depth_of_field);
  EXPECT_EQ(spec.camera.depth_of_field->f_stop, 1.4);
  EXPECT_EQ(spec.camera.depth_of_field->focus_distance_m, 2.5);
  EXPECT_EQ(spec.camera.motion.shutter_s, 0.02);
  ASSERT_TRUE(spec.output.bloom);
  EXPECT_EQ(spec.output.bloom->intensity, 0.5);
  EXPECT_EQ(spec.output.pixel_filter.kind, PixelFilterKind::kGaussian);
  EXPECT_EQ(spec.output.grade, (ColorGrade{3200, -7, 1.25, 0.5}));
  EXPECT_EQ(std::get<BuiltinName>(spec.environment.map).name, "overcast");
  const glm::vec3 color = std::get<ColorBackground>(spec.environment.background).color;
  EXPECT_FLOAT_EQ(color.x, 1);
  EXPECT_FLOAT_EQ(color.y, 0);
  EXPECT_NEAR(color.z, 0.2158605, 1e-6);  // sRGB 128 as published in many tables
  EXPECT_EQ(spec.environment.sun, SunMode::kKeep);
  EXPECT_EQ(spec.environment.visibility, EnvironmentVisibility::kOn);
  EXPECT_EQ(spec.scene.shading_model, ShadingModel::kPhong);
  EXPECT_TRUE(spec.environment.ground);
  EXPECT_EQ(spec.output.layers, (std::vector{FilmLayer::kDepth, FilmLayer::kNormal}));
  EXPECT_EQ(spec.output.shown, FilmLayer::kAlbedo);
}

TEST(RenderOptions, FormatsHaveTheirOwn) {
  RenderOptions options;
  options.format = "webp";
  options.compression_quality = 75;
  options.lossless = true;
  RenderSpec spec = parsed("{}");
  apply_options(options, parsed(request_document(options, "")), spec);
  EXPECT_EQ(spec.output.format, OutputFormat::kWebp);
  EXPECT_EQ(spec.output.compression_quality, 75);
  EXPECT_TRUE(spec.output.lossless);
  options = {};
  options.bit_depth = 16;
  apply_options(options, parsed(request_document(options, "")), spec);
  EXPECT_EQ(spec.output.bit_depth, 16);
}

TEST(RenderOptions, BlursTheEnvironmentThatIsSeen) {
  RenderOptions options;
  options.blur_degrees = 9;
  const RenderSpec said = parsed(request_document(options, ""));
  EXPECT_NEAR(std::get<EnvironmentBackground>(said.environment.background).blur_rad, 0.15707963, 1e-8);
  RenderSpec spec = parsed(R"({"environment":{"background":{"type":"transparent"}}})");
  apply_options(options, said, spec);
  EXPECT_TRUE(std::holds_alternative<EnvironmentBackground>(spec.environment.background));
}

TEST(RenderOptions, AMeterReplacesTheOther) {
  RenderOptions options;
  options.auto_exposure = true;
  RenderSpec spec = parsed(R"({"camera":{"ev100":15}})");
  apply_options(options, parsed(request_document(options, "")), spec);
  EXPECT_TRUE(std::holds_alternative<AutoExposure>(spec.camera.metering));
  options.auto_exposure = false;
  options.ev100 = 3;
  apply_options(options, parsed(request_document(options, "")), spec);
  EXPECT_EQ(std::get<PhysicalExposure>(spec.camera.metering).ev100, 3);
}

TEST(RenderOptions, AppliedToARequestTheyGiveTheSamePicture) {
  const RenderSpec said = parsed(request_document(everything(), ""));
  RenderSpec spec = parsed(
      R"({"camera":{"lookAt":{"eye":[1,2,3]},"exposureEv":-1},"output":{"width":9,"toneMap":"none"}})");
  apply_options(everything(), said, spec);
  EXPECT_EQ(spec_hash(spec), spec_hash(said));
}

TEST(RenderOptions, WhatIsNotSaidStays) {
  const std::string document =
      R"({"camera":{"lookAt":{"eye":[1,2,3]}},"output":{"width":9,"toneMap":"none"}})";
  RenderSpec spec = parsed(document);
  apply_options({}, parsed("{}"), spec);
  EXPECT_EQ(spec_hash(spec), spec_hash(parsed(document)));
}

TEST(RenderOptions, AColourThatIsNone) {
  for (const char* background : {"#fff", "#gg0000", "#12345", "#"}) {
    RenderOptions options;
    options.background = background;
    EXPECT_THROW(request_document(options, ""), Error) << background;
  }
}

TEST(FrameFiles, OnePlaceForTheNumber) {
  EXPECT_EQ(FrameFiles::parse("a/frame_%04d.png")->name_of(0), "a/frame_0001.png");
  EXPECT_EQ(FrameFiles::parse("f%d.exr")->name_of(11), "f12.exr");
  EXPECT_EQ(FrameFiles::parse("##.webp")->name_of(122), "123.webp");
  EXPECT_EQ(FrameFiles::parse("100%_{}_###.png")->name_of(6), "100%_{}_007.png");
  for (const char* name : {"out.png", "100%.png", "a#b#.png", "%s.png", "%99999999999d.png", ""})
    EXPECT_FALSE(FrameFiles::parse(name)) << name;
}

}  // namespace
}  // namespace furnace
