// Film layers whose numbers are known in closed form.
#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/frame/cryptomatte.hpp"
#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

class FilmLayersGlTest : public ClosedFormGlTest {
 protected:
  static const ImageLayer& layer(const Film& film, std::string_view name) {
    const auto found = std::find_if(film.layers.begin(), film.layers.end(),
                                    [&](const ImageLayer& one) { return one.name == name; });
    if (found == film.layers.end()) throw std::runtime_error("no layer " + std::string(name));
    return *found;
  }
  static float number(const Film& film, std::string_view name, int x, int y, std::size_t channel = 0) {
    const ImageLayer& one = layer(film, name);
    const std::size_t at = (std::size_t(y) * std::size_t(one.image.extent.width) + std::size_t(x)) *
                               std::size_t(one.image.channels) +
                           channel;
    return one.image.samples<float>()[at];
  }
  static glm::vec3 vector(const Film& film, std::string_view name, int x, int y) {
    return {number(film, name, x, y, 0), number(film, name, x, y, 1), number(film, name, x, y, 2)};
  }

  // A plane of 1 m, 4 m below an eye that sees 4 m: the pixels from 24 to 39 of 64.
  static RenderSpec plane_from_above(const MaterialOverride& material) {
    RenderSpec spec = spec_of("plane", material, glm::vec3(1));
    spec.camera.view = LookAtCamera{{0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5)};
    return spec;
  }
  static float place(int pixel) { return (float(pixel) + 0.5f) / 16 - 2; }
};

TEST_F(FilmLayersGlTest, PlacesOfAPlane) {
  RenderSpec spec = plane_from_above({});
  spec.output.layers = {FilmLayer::kDepth, FilmLayer::kPosition, FilmLayer::kUv};
  for (const int samples : {1, 5}) {
    spec.output.samples = samples;
    const Film film = render(spec);
    for (const int y : {24, 30, 39}) {
      for (const int x : {24, 31, 39}) {
        EXPECT_NEAR(number(film, "depth", x, y), 4, 1e-5);
        const glm::vec3 position = vector(film, "position", x, y);
        EXPECT_NEAR(position.x, place(x), 1e-5);
        EXPECT_NEAR(position.y, 0, 1e-5);
        EXPECT_NEAR(position.z, place(y), 1e-5);
        EXPECT_NEAR(number(film, "uv", x, y, 0), place(x) + 0.5f, 1e-5);
      }
    }
    EXPECT_EQ(number(film, "depth", 23, 30), std::numeric_limits<float>::infinity());
    EXPECT_EQ(vector(film, "position", 40, 30), glm::vec3(0));
  }
}

// Of a pixel that sees two surfaces depth is the nearer one's, not a mean.
TEST_F(FilmLayersGlTest, DepthIsNeverMixed) {
  RenderSpec spec = plane_from_above({});
  NodeSpec low = spec.scene.nodes[0];
  low.translation = {0, -2, 0};
  low.scale = glm::vec3(8);
  spec.scene.nodes.push_back(low);
  spec.scene.nodes[0].rotation = glm::angleAxis(0.3f, glm::vec3(0, 1, 0));
  spec.output.layers = {FilmLayer::kDepth, FilmLayer::kObjectId, FilmLayer::kCoverage};
  spec.output.samples = 4;
  const Film film = render(spec);
  int near_count = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const float depth = number(film, "depth", x, y), id = number(film, "objectId", x, y);
      EXPECT_TRUE((std::abs(depth - 4) < 1e-4 && id == 1) || (std::abs(depth - 6) < 1e-4 && id == 2))
          << depth << " " << id;
      near_count += id == 1;
      EXPECT_NEAR(number(film, "coverage", x, y), 1, 1e-6);
    }
  }
  // 256 pixels and half of those on its edges, at most.
  EXPECT_GT(near_count, 256);
  EXPECT_LT(near_count, 256 + 64);
}

// Depth is along the viewing direction, whatever the pixel; the eye is 3 m from the middle of a sphere of 1/2 m.
TEST_F(FilmLayersGlTest, SphereByItsEquation) {
  RenderSpec spec = spec_of("sphere", {}, glm::vec3(1));
  spec.camera.view = LookAtCamera{{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.4};
  spec.output.layers = {FilmLayer::kDepth, FilmLayer::kPosition, FilmLayer::kNormal, FilmLayer::kViewNormal};
  const Film film = render(spec);
  const double tangent = std::tan(0.2);
  // The built-in sphere's triangles lie up to this far within it.
  constexpr double kFlat = 2e-3;
  int seen = 0;
  for (int y = 0; y < 64; y += 3) {
    for (int x = 0; x < 64; x += 3) {
      const glm::dvec3 ray((2 * (x + 0.5) / 64 - 1) * tangent, (1 - 2 * (y + 0.5) / 64) * tangent, -1);
      const double a = glm::dot(ray, ray), b = -3 * ray.z, root = b * b - a * (9 - 0.25);
      // Within 0.95 of the silhouette the tessellation counts little.
      if (root < 0.1 * b * b * 0.03) continue;
      const double depth = (b - std::sqrt(root)) / a;
      const glm::dvec3 point = glm::dvec3(0, 0, 3) + ray * depth;
      ++seen;
      EXPECT_NEAR(number(film, "depth", x, y), depth, 6 * kFlat);
      EXPECT_LT(glm::distance(glm::dvec3(vector(film, "position", x, y)), point), 6 * kFlat);
      EXPECT_LT(glm::distance(glm::dvec3(vector(film, "normal", x, y)), point * 2.0), 0.03);
      EXPECT_LT(glm::distance(vector(film, "viewNormal", x, y), vector(film, "normal", x, y)), 1e-6f);
    }
  }
  EXPECT_GT(seen, 100);
}

TEST_F(FilmLayersGlTest, ViewNormalsLookAtTheCamera) {
  RenderSpec spec = plane_from_above({});
  spec.output.layers = {FilmLayer::kNormal, FilmLayer::kViewNormal};
  const Film film = render(spec);
  EXPECT_LT(glm::distance(vector(film, "normal", 30, 30), glm::vec3(0, 1, 0)), 1e-6f);
  EXPECT_LT(glm::distance(vector(film, "viewNormal", 30, 30), glm::vec3(0, 0, 1)), 1e-6f);
}

// With depth of field, places are what the middle of the lens sees.
TEST_F(FilmLayersGlTest, PlacesKnowNoLens) {
  RenderSpec spec = plane_from_above({});
  spec.output.layers = {FilmLayer::kPosition, FilmLayer::kCoverage};
  spec.output.samples = 8;
  spec.camera.depth_of_field.emplace().aperture_diameter_m = 0.5;
  spec.camera.depth_of_field->focus_distance_m = 2;
  const Film film = render(spec);
  EXPECT_NEAR(vector(film, "position", 30, 30).x, place(30), 1e-5);
  // The blurred edge, which a mean shows, is several pixels wide.
  EXPECT_GT(number(film, "coverage", 21, 31), 0.05f);
  EXPECT_LT(number(film, "coverage", 26, 31), 0.95f);
}

TEST_F(FilmLayersGlTest, MaterialsTellTheirNumbers) {
  MaterialOverride material;
  material.base_color = glm::vec4(0.5f, 0.25f, 0.125f, 1);
  material.metallic = 0.75f;
  material.perceptual_roughness = 0.375f;
  RenderSpec spec = plane_from_above(material);
  spec.output.layers = {FilmLayer::kAlbedo, FilmLayer::kRoughness, FilmLayer::kMetallic,
                        FilmLayer::kOcclusion};
  for (const AlphaMode mode : {AlphaMode::kOpaque, AlphaMode::kBlend}) {
    spec.scene.materials["m"].alpha_mode = mode;
    const float cover = mode == AlphaMode::kBlend ? 0.5f : 1;
    spec.scene.materials["m"].base_color->a = cover;
    const Film film = render(spec);
    EXPECT_LT(glm::distance(vector(film, "albedo", 30, 30), cover * glm::vec3(0.5f, 0.25f, 0.125f)), 1e-6f);
    EXPECT_NEAR(number(film, "roughness", 30, 30), cover * 0.375f, 1e-6f);
    EXPECT_NEAR(number(film, "metallic", 30, 30), cover * 0.75f, 1e-6f);
    EXPECT_NEAR(number(film, "occlusion", 30, 30), cover, 1e-6f);
    EXPECT_EQ(number(film, "roughness", 3, 3), 0);
  }
}

// Mattes and places know nothing of blended surfaces, and say so.
TEST_F(FilmLayersGlTest, WhatIsBlendedIsSeenThrough) {
  MaterialOverride veil;
  veil.alpha_mode = AlphaMode::kBlend;
  veil.base_color = glm::vec4(1, 1, 1, 0.5f);
  RenderSpec spec = plane_from_above(veil);
  NodeSpec low = spec.scene.nodes[0];
  low.translation = {0, -2, 0};
  low.scale = glm::vec3(8);
  low.material = "gold";
  low.name = "floor";
  spec.scene.nodes.push_back(low);
  spec.output.layers = {FilmLayer::kAlbedo};
  EXPECT_TRUE(render(spec).notes.empty());
  spec.output.layers = {FilmLayer::kDepth, FilmLayer::kCryptoObject};
  const Film film = render(spec);
  EXPECT_NEAR(number(film, "depth", 30, 30), 6, 1e-5);
  EXPECT_EQ(number(film, "cryptoObject00", 30, 30, 0), matte_id("floor"));
  EXPECT_EQ(number(film, "cryptoObject00", 30, 30, 1), 1);
  ASSERT_EQ(film.notes.size(), 1u);
  EXPECT_EQ(film.notes[0].code, "layers-see-through");
}

// D, F and G of a plane seen at right angles whose light comes from 60 degrees, and of one without lights, seen in its mirror.
TEST_F(FilmLayersGlTest, TermsOfTheFormula) {
  MaterialOverride material;
  material.base_color = glm::vec4(1);
  material.metallic = 0.f;
  material.perceptual_roughness = 0.5f;
  RenderSpec spec = plane_from_above(material);
  spec.output.layers = {FilmLayer::kIrradiance, FilmLayer::kPrefilteredRadiance, FilmLayer::kDistribution,
                        FilmLayer::kFresnel, FilmLayer::kGeometry};
  spec.environment.map = EnvironmentColor{glm::vec3(0.5f)};
  spec.camera.exposure_ev = 1;
  spec.camera.view = LookAtCamera{{0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 0.01};
  const double alpha2 = std::pow(0.5, 4);
  {
    const Film film = render(spec);
    EXPECT_NEAR(number(film, "irradiance", 32, 32), kPi, 5e-3);
    EXPECT_NEAR(number(film, "prefilteredRadiance", 32, 32), 1, 2e-3);
    EXPECT_NEAR(number(film, "distribution", 32, 32) * kPi * alpha2, 1, 1e-3);
    EXPECT_NEAR(number(film, "fresnel", 32, 32), 0.04, 1e-4);
    EXPECT_NEAR(number(film, "geometry", 32, 32), 1, 1e-3);
  }
  Light light;
  light.kind = LightKind::kDirectional;
  light.direction = glm::normalize(glm::dvec3(-std::sqrt(3.0), -1, 0));
  spec.scene.lights = {light};
  const Film film = render(spec);
  const double cosine = std::cos(kPi / 6),
               cosine2 = cosine * cosine;  // of half the angle between light and eye
  const double d = cosine2 * (alpha2 - 1) + 1;
  EXPECT_NEAR(number(film, "distribution", 32, 32) / (alpha2 / (kPi * d * d)), 1, 2e-3);
  EXPECT_NEAR(number(film, "fresnel", 32, 32), 0.04 + 0.96 * std::pow(1 - cosine, 5), 1e-5);
  // Heitz 2014: 1 / (1 + lambda(v) + lambda(l)), lambda(v) = 0 at right angles.
  const double lambda = (std::sqrt(1 + alpha2 * 3) - 1) / 2;
  EXPECT_NEAR(number(film, "geometry", 32, 32), 1 / (1 + lambda), 2e-3);
}

// A line a pixel wide along the diagonal of two triangles, half of one along the outer edges, at any resolution.
TEST_F(FilmLayersGlTest, WiresAreAPixelWide) {
  for (const int size : {64, 256}) {
    RenderSpec spec = plane_from_above({});
    spec.output.width = spec.output.height = size;
    spec.output.layers = {FilmLayer::kWireframe, FilmLayer::kPrimitiveId};
    const Film film = render(spec);
    double sum = 0;
    float most_primitive = 0;
    for (const float value : layer(film, "wireframe").image.samples<float>()) sum += double(value);
    for (const float value : layer(film, "primitiveId").image.samples<float>())
      most_primitive = std::max(most_primitive, value);
    ASSERT_EQ(most_primitive, 1);
    const double side_px = size / 4.0;
    EXPECT_NEAR(sum / (side_px * std::sqrt(2.0) + 4 * side_px / 2), 1, 0.08) << size;
  }
}

// Two planes that meet in the middle of a pixel: each has half of it, and each name its own number.
TEST_F(FilmLayersGlTest, MattesShareAPixel) {
  RenderSpec spec = plane_from_above({});
  spec.output.samples = 4;
  spec.output.layers = {FilmLayer::kCryptoObject, FilmLayer::kCryptoMaterial};
  spec.scene.nodes[0].name = "left";
  NodeSpec right = spec.scene.nodes[0];
  right.name = "right";
  right.material = "gold";
  // Their edges meet at x = 1/32 m: the middle of pixel 32.
  spec.scene.nodes[0].translation.x = 1 / 32.f - 0.5f;
  right.translation.x = 1 / 32.f + 0.5f;
  spec.scene.nodes.push_back(right);
  spec.output.pixel_filter = {PixelFilterKind::kBox, 0.5};
  const Film film = render(spec);
  const float first = number(film, "cryptoObject00", 32, 30, 0),
              second = number(film, "cryptoObject00", 32, 30, 2);
  EXPECT_EQ(std::minmax(first, second), std::minmax(matte_id("left"), matte_id("right")));
  EXPECT_NEAR(number(film, "cryptoObject00", 32, 30, 1) + number(film, "cryptoObject00", 32, 30, 3), 1, 1e-6);
  EXPECT_NEAR(number(film, "cryptoObject00", 32, 30, 1), 0.5, 0.13);  // four samples along x in a box
  EXPECT_EQ(number(film, "cryptoObject00", 28, 30, 0), matte_id("left"));
  EXPECT_NEAR(number(film, "cryptoObject00", 28, 30, 1), 1, 1e-6);
  EXPECT_EQ(number(film, "cryptoObject00", 28, 30, 3), 0);
  EXPECT_EQ(number(film, "cryptoMaterial00", 36, 30, 0), matte_id("gold"));
  EXPECT_EQ(number(film, "cryptoObject01", 32, 30, 1), 0);
  EXPECT_EQ(number(film, "cryptoObject00", 3, 3, 1), 0);
  ASSERT_EQ(film.attributes.size(), 8u);
  EXPECT_TRUE(film.attributes[3].key.ends_with("/manifest"));
  EXPECT_NE(film.attributes[3].value.find("\"left\":\""), std::string::npos);
}

TEST_F(FilmLayersGlTest, WhoAsksForLayersGetsTheSamePicture) {
  RenderSpec spec;
  spec.output.width = 80;
  spec.output.height = 60;
  spec.output.format = OutputFormat::kExr;
  spec.scene.lights.emplace_back();
  NodeSpec ball;
  ball.mesh = "shader-ball";
  spec.scene.nodes = {ball};
  for (const int samples : {1, 3}) {
    spec.output.samples = samples;
    spec.output.layers.clear();
    const Film plain = render(spec);
    EXPECT_TRUE(plain.layers.empty());
    for (const FilmLayerRow& row : kFilmLayers) spec.output.layers.push_back(row.layer);
    const Film film = render(spec);
    EXPECT_EQ(film.image.pixels, plain.image.pixels);
    // Mattes have three levels each.
    EXPECT_EQ(film.layers.size(), kFilmLayers.size() + 4);
    for (const ImageLayer& one : film.layers) {
      if (one.name == "depth" || one.image.type != SampleType::kFloat32) continue;
      for (const float value : one.image.samples<float>()) ASSERT_TRUE(std::isfinite(value)) << one.name;
    }
  }
}

TEST_F(FilmLayersGlTest, TilesLeaveNoTrace) {
  static WorkerPool pool(2);
  RendererConfig config;
  config.gl = {"software", gl::Determinism::kExact};
  config.max_tile_px = 32;
  Renderer tiled(config, pool, decode::in_process_decoder());
  RenderSpec spec = spec_of("torus", {}, glm::vec3(1));
  spec.output.width = 80;
  spec.output.samples = 2;
  for (const FilmLayerRow& row : kFilmLayers) spec.output.layers.push_back(row.layer);
  const Film whole = render(spec), pieces = tiled.render(spec, Deadline());
  ASSERT_EQ(whole.layers.size(), pieces.layers.size());
  for (std::size_t i = 0; i < whole.layers.size(); ++i) {
    const ImageLayer &a = whole.layers[i], &b = pieces.layers[i];
    double most = 0;
    for (std::size_t k = 0; k < a.image.samples<float>().size(); ++k) {
      const float x = a.image.samples<float>()[k], y = b.image.samples<float>()[k];
      if (std::bit_cast<std::uint32_t>(x) != std::bit_cast<std::uint32_t>(y))
        most = std::max(most, double(std::abs(x - y)) / std::max(1.0, double(std::abs(y))));
    }
    // A tile's rays are interpolated from other corners, which narrow lobes magnify.
    EXPECT_LT(most, 1e-4) << a.name;
  }
}

// What is shown alone is the same layer.
TEST_F(FilmLayersGlTest, ShownAloneItHasTheSameNumbers) {
  MaterialOverride material;
  material.emissive = glm::vec3(0.25f, 0.5f, 1);
  RenderSpec spec = spec_of("sphere", material, glm::vec3(1));
  for (const FilmLayer wanted : {FilmLayer::kDepth, FilmLayer::kNormal, FilmLayer::kRoughness,
                                 FilmLayer::kEmission, FilmLayer::kSpecularEnvironment}) {
    spec.output.layers = {wanted};
    spec.output.shown = wanted;
    const Film film = render(spec);
    const ImageLayer& beside = film.layers.front();
    ASSERT_EQ(film.image.channels, beside.image.channels) << beside.name;
    EXPECT_EQ(film.image.pixels, beside.image.pixels) << beside.name;
  }
}

TEST_F(FilmLayersGlTest, ViewsOfPlanes) {
  MaterialOverride material;
  material.base_color = glm::vec4(0.5f, 0.25f, 0.125f, 1);
  material.perceptual_roughness = 0.4f;
  RenderSpec spec = plane_from_above(material);
  spec.output.format = OutputFormat::kPng;
  const auto shown = [&](FilmLayer layer) {
    spec.output.shown = layer;
    const Film film = render(spec);
    const auto samples = film.image.samples<std::uint8_t>();
    const std::size_t at = (30 * 64 + 30) * std::size_t(film.image.channels);
    return glm::ivec3(samples[at], samples[at + 1], samples[at + 2]);
  };
  EXPECT_EQ(shown(FilmLayer::kNormal), glm::ivec3(128, 255, 128));
  EXPECT_EQ(shown(FilmLayer::kViewNormal), glm::ivec3(128, 128, 255));
  EXPECT_EQ(shown(FilmLayer::kRoughness), glm::ivec3(102));
  EXPECT_EQ(shown(FilmLayer::kAlbedo), glm::ivec3(188, 137, 99));  // sRGB of 1/2, 1/4, 1/8
  EXPECT_EQ(shown(FilmLayer::kCoverage), glm::ivec3(255));
  EXPECT_EQ(shown(FilmLayer::kEmission), glm::ivec3(0));
  spec.environment.background = TransparentBackground{};
  const Film film = render(spec);
  EXPECT_EQ(film.image.channels, 4);
  EXPECT_EQ(film.image.samples<std::uint8_t>()[3], 0);
}

}  // namespace
}  // namespace furnace
