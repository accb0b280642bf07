// The parts of the light sum to the picture: exactly by construction, so up to rounding.
#include <algorithm>
#include <cmath>

#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

class LightPartsGlTest : public ClosedFormGlTest {
 protected:
  // Every lobe there is, a light with a shadow beside the environment.
  static RenderSpec gallery() {
    RenderSpec spec;
    MaterialOverride metal, coated, cloth, glass, leaf, lamp, sign;
    metal.metallic = 1.f;
    metal.perceptual_roughness = 0.3f;
    metal.anisotropy = 0.7f;
    coated.base_color = glm::vec4(0.6f, 0.05f, 0.02f, 1);
    coated.metallic = 0.f;
    coated.clearcoat = 1.f;
    coated.clearcoat_perceptual_roughness = 0.4f;
    coated.emissive = glm::vec3(0.1f, 0.3f, 0.2f);
    cloth.base_color = glm::vec4(0.1f, 0.1f, 0.4f, 1);
    cloth.metallic = 0.f;
    cloth.sheen_color = glm::vec3(0.8f, 0.7f, 0.6f);
    cloth.sheen_perceptual_roughness = 0.4f;
    glass.base_color = glm::vec4(0.7f, 0.9f, 1, 1);
    glass.metallic = 0.f;
    glass.perceptual_roughness = 0.2f;
    glass.transmission = 0.9f;
    glass.thickness_m = 0.5f;
    leaf.base_color = glm::vec4(0.2f, 0.6f, 0.1f, 1);
    leaf.metallic = 0.f;
    leaf.diffuse_transmission = 0.6f;
    lamp.emissive = glm::vec3(4, 3, 2);
    sign.base_color = glm::vec4(0.9f, 0.4f, 0.1f, 1);
    sign.unlit = true;
    spec.scene.materials = {{"metal", metal}, {"coated", coated}, {"cloth", cloth}, {"glass", glass},
                            {"leaf", leaf},   {"lamp", lamp},     {"sign", sign}};
    spec.scene.nodes = {node("plane", "leaf", {0, -0.5f, 0}, 5),  node("torus", "metal", {-1.2f, 0, 0}),
                        node("sphere", "coated", {0, 0, 0}),      node("sphere", "cloth", {1.2f, 0, 0}),
                        node("sphere", "glass", {0.5f, 0, 1.2f}), node("cube", "lamp", {-1, 0, 1.3f}, 0.4f),
                        node("cube", "sign", {1.6f, 0, 1}, 0.4f)};
    Light light;
    light.kind = LightKind::kSpot;
    light.position = {1, 3, 2};
    light.direction = glm::normalize(glm::dvec3(-1, -3, -2));
    light.intensity = glm::dvec3(90, 80, 70);
    light.radius_m = 0.1;
    spec.scene.lights = {light};
    spec.output.width = 64;
    spec.output.height = 48;
    spec.output.format = OutputFormat::kExr;
    spec.output.exr_type = SampleType::kFloat32;
    for (const FilmLayerRow& row : kFilmLayers)
      if (row.kind == FilmLayerKind::kPart) spec.output.layers.push_back(row.layer);
    return spec;
  }

  // The largest difference of their sum from the picture, relative, but for what is darker than 1/100.
  static double largest_error(const Film& film) {
    const auto picture = film.image.samples<float>();
    double largest = 0;
    for (std::size_t pixel = 0; pixel < std::size_t(film.image.extent.area()); ++pixel) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (const ImageLayer& part : film.layers) sum += double(part.image.samples<float>()[pixel * 3 + c]);
        const double whole = double(picture[pixel * std::size_t(film.image.channels) + c]);
        largest = std::max(largest, std::abs(sum - whole) / std::max(whole, 0.01));
      }
    }
    return largest;
  }
  static double mean(const Film& film, std::string_view name) {
    double sum = 0;
    for (const ImageLayer& part : film.layers)
      if (part.name == name)
        for (const float value : part.image.samples<float>()) sum += double(value);
    return sum / double(3 * film.image.extent.area());
  }
};

// Sums of thirteen floats, each rounded a few times.
constexpr double kRounding = 1e-4;
// The veil holds half floats: each part is rounded to 2^-11, and so is the picture.
constexpr double kVeilRounding = 4e-3;

TEST_F(LightPartsGlTest, OfEveryLobe) {
  RenderSpec spec = gallery();
  for (const int samples : {1, 16}) {
    spec.output.samples = samples;
    const Film film = render(spec);
    EXPECT_LT(largest_error(film), kRounding) << samples;
    for (const FilmLayer part : spec.output.layers) {
      if (part == FilmLayer::kGlow) continue;
      EXPECT_GT(mean(film, row_of(part).name), 1e-4) << row_of(part).name;
    }
  }
}

TEST_F(LightPartsGlTest, BeforeEveryBackground) {
  RenderSpec spec = gallery();
  spec.camera.exposure_ev = -1.5;
  const std::vector<BackgroundSpec> backgrounds = {ColorBackground{{0.2f, 0.3f, 0.5f}}, GradientBackground{},
                                                   TransparentBackground{}};
  for (const BackgroundSpec& background : backgrounds) {
    spec.environment.background = background;
    EXPECT_LT(largest_error(render(spec)), kRounding) << background.index();
  }
}

TEST_F(LightPartsGlTest, OnAGround) {
  RenderSpec spec = gallery();
  spec.scene.nodes.erase(spec.scene.nodes.begin());
  spec.environment.ground.emplace();
  for (const bool transparent : {false, true}) {
    if (transparent) spec.environment.background = TransparentBackground{};
    EXPECT_LT(largest_error(render(spec)), kRounding);
  }
}

TEST_F(LightPartsGlTest, WithGlow) {
  RenderSpec spec = gallery();
  for (const BloomSource source : {BloomSource::kAll, BloomSource::kEmission}) {
    spec.output.bloom = Bloom{0.3, 0.2, source, 0.8};
    const Film film = render(spec);
    EXPECT_LT(largest_error(film), kRounding);
    EXPECT_NE(mean(film, "glow"), 0);
  }
}

TEST_F(LightPartsGlTest, BehindAVeil) {
  RenderSpec spec = gallery();
  MaterialOverride veil;
  veil.base_color = glm::vec4(0.8f, 0.6f, 0.4f, 0.4f);
  veil.metallic = 0.f;
  veil.clearcoat = 0.5f;
  veil.alpha_mode = AlphaMode::kBlend;
  spec.scene.materials["veil"] = veil;
  spec.scene.nodes.push_back(node("sphere", "veil", {-0.3f, 0.2f, 1}, 1.3f));
  for (const int samples : {1, 4}) {
    spec.output.samples = samples;
    EXPECT_LT(largest_error(render(spec)), kVeilRounding);
  }
}

// Glass that covers a part of what is straight behind it.
TEST_F(LightPartsGlTest, ThroughPartialGlass) {
  RenderSpec spec = gallery();
  spec.scene.materials["glass"].alpha_mode = AlphaMode::kBlend;
  spec.scene.materials["glass"].base_color->a = 0.5f;
  EXPECT_LT(largest_error(render(spec)), kRounding);
}

TEST_F(LightPartsGlTest, OfOlderModels) {
  for (const ShadingModel model : {ShadingModel::kSchlickBeckmann, ShadingModel::kPhong}) {
    RenderSpec spec = gallery();
    spec.scene.nodes.resize(4);  // without glass
    spec.scene.shading_model = model;
    EXPECT_LT(largest_error(render(spec)), kRounding);
  }
}

}  // namespace
}  // namespace furnace
