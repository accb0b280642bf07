// Scene-linear float films of built-in meshes, for frames whose radiance is known.
#pragma once

#include <gtest/gtest.h>

#include "renderer/base/worker_pool.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/renderer.hpp"

namespace furnace {

class ClosedFormGlTest : public testing::Test {
 protected:
  static Renderer& renderer() {
    static WorkerPool pool(2);
    static Renderer instance = [] {
      gl::apply_determinism(gl::Determinism::kExact);
      RendererConfig config;
      config.gl = {"software", gl::Determinism::kExact};
      return Renderer(config, pool, decode::in_process_decoder());
    }();
    return instance;
  }
  static Film render(const RenderSpec& spec) { return renderer().render(spec, Deadline()); }

  // A scene-linear float film of one built-in mesh in an environment of radiance `radiance`.
  static RenderSpec spec_of(const char* mesh, const MaterialOverride& material, glm::vec3 radiance) {
    RenderSpec spec;
    NodeSpec node;
    node.mesh = mesh;
    node.material = "m";
    spec.scene.nodes = {node};
    spec.scene.materials["m"] = material;
    spec.environment.map = EnvironmentColor{radiance};
    spec.output.width = spec.output.height = 64;
    spec.output.format = OutputFormat::kExr;
    spec.output.exr_type = SampleType::kFloat32;
    return spec;
  }
  static NodeSpec node(const char* mesh, const char* material, glm::vec3 at, float scale = 1) {
    NodeSpec out;
    out.mesh = mesh;
    out.material = material;
    out.translation = at;
    out.scale = glm::vec3(scale);
    return out;
  }
  static glm::vec3 pixel(const Film& film, int x, int y) {
    const auto samples = film.image.samples<float>();
    const std::size_t at = (std::size_t(y) * std::size_t(film.image.extent.width) + std::size_t(x)) *
                           std::size_t(film.image.channels);
    return {samples[at], samples[at + 1], samples[at + 2]};
  }
};

}  // namespace furnace
