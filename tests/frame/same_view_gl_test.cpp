// Pictures that follow one another: what the first one found visible must serve the next one only where it is the same.
#include <functional>

#include "tests/frame/closed_form.hpp"

namespace furnace {
namespace {

struct Change {
  const char* name;
  std::function<void(RenderSpec&)> make;
};

class SameViewGlTest : public ClosedFormGlTest {
 protected:
  static RenderSpec scene() {
    RenderSpec spec = spec_of("cube", MaterialOverride{}, glm::vec3(1));
    spec.scene.nodes.push_back(node("sphere", "m", {0.8f, 0.3f, 0.4f}, 0.6f));
    spec.scene.nodes.push_back(node("plane", "glass", {0, 0, 0.9f}, 0.5f));
    spec.scene.materials["m"].perceptual_roughness = 0.4f;
    spec.scene.materials["glass"].alpha_mode = AlphaMode::kBlend;
    spec.scene.materials["glass"].base_color = glm::vec4(0.9f, 0.2f, 0.1f, 0.5f);
    spec.scene.materials["glass"].double_sided = true;
    spec.environment.map = BuiltinName{"studio"};
    spec.camera.view = LookAtCamera{{1.5f, 1, 3}};  // no framing that would give a change away
    return spec;
  }
  // After a picture of another size nothing is left to take over.
  static std::vector<std::byte> alone(const RenderSpec& spec) {
    RenderSpec other = scene();
    other.output.width = 40;
    render(other);
    return render(spec).image.pixels;
  }
};

TEST_F(SameViewGlTest, EachIsAsIfItCameAlone) {
  const Change changes[] = {
      {"colour", [](RenderSpec& s) { s.scene.materials["m"].base_color = glm::vec4(0.1f, 0.6f, 0.2f, 1); }},
      {"exposure", [](RenderSpec& s) { s.camera.exposure_ev = 1; }},
      {"environment", [](RenderSpec& s) { s.environment.rotation_rad = 1; }},
      {"light", [](RenderSpec& s) { s.scene.lights.emplace_back().kind = LightKind::kDirectional; }},
      {"glow", [](RenderSpec& s) { s.output.bloom = Bloom{}; }},
      {"blended", [](RenderSpec& s) { s.scene.materials["m"].alpha_mode = AlphaMode::kBlend; }},
      {"masked",
       [](RenderSpec& s) {
         s.scene.materials["m"].alpha_mode = AlphaMode::kMask;
         s.scene.materials["m"].base_color = glm::vec4(1, 1, 1, 0.3f);
       }},
      {"seen through", [](RenderSpec& s) { s.scene.materials["m"].transmission = 1.f; }},
      {"layers",
       [](RenderSpec& s) {
         s.output.layers = {FilmLayer::kNormal, FilmLayer::kDepth};
       }},
      {"moved", [](RenderSpec& s) { s.scene.nodes[1].translation.x += 0.01f; }},
      {"another mesh", [](RenderSpec& s) { s.scene.nodes[1].mesh = "torus"; }},
      {"fewer", [](RenderSpec& s) { s.scene.nodes.erase(s.scene.nodes.begin() + 1); }},
      {"inside out", [](RenderSpec& s) { s.scene.nodes[0].scale = glm::vec3(-1.01f, 1, 1); }},
      {"another view",
       [](RenderSpec& s) {
         s.camera.view = LookAtCamera{{1.51f, 1, 3}};
       }},
      {"more samples", [](RenderSpec& s) { s.output.samples = 4; }},
  };
  const std::vector<std::byte> first = alone(scene());
  for (const Change& change : changes) {
    SCOPED_TRACE(change.name);
    RenderSpec changed = scene();
    change.make(changed);
    const std::vector<std::byte> expected = alone(changed);
    EXPECT_TRUE(render(scene()).image.pixels == first);
    EXPECT_TRUE(render(changed).image.pixels == expected);
    EXPECT_TRUE(render(scene()).image.pixels == first);
    // Layers leave the picture as it is, and must find all of it.
    EXPECT_NE(expected == first, changed.output.layers.empty());
  }
}

}  // namespace
}  // namespace furnace
