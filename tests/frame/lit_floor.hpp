// A floor that shows how much light falls on it.
#pragma once

#include <cmath>

#include "renderer/scene/transform.hpp"
#include "tests/frame/closed_form.hpp"

namespace furnace {

// A red floor, 8 m wide, seen from straight above by parallel rays, 8 pixels a metre; all else is dark.
class LitFloorGlTest : public ClosedFormGlTest {
 protected:
  static RenderSpec floor_under(const Light& light) {
    MaterialOverride material;
    material.base_color = glm::vec4(0.5f, 0, 0, 1);
    material.metallic = 0.f;
    material.perceptual_roughness = 1.f;
    RenderSpec spec = spec_of("plane", material, glm::vec3(0));
    spec.scene.nodes[0].scale = glm::vec3(8);
    spec.scene.lights = {light};
    OrbitCamera above;
    above.elevation_rad = kPi / 2;
    above.azimuth_rad = 0;
    above.fit = 1;
    above.orthographic = true;
    spec.camera.view = above;
    return spec;
  }
  // Irradiance on the floor times a constant, at x, z (m): what red has more than the colourless gloss.
  static double light_at(const Film& film, double x, double z) {
    const int column = int(std::floor((x + 4) * 8)), row = int(std::floor((z + 4) * 8));
    const glm::vec3 color = pixel(film, column, row);
    return double(color.r) - double(color.g);
  }
};

}  // namespace furnace
