// A white square that an animation moves, seen from in front without perspective: 16 px a metre, 64 px a side.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tests/frame/closed_form.hpp"
#include "tests/scene/gltf_builder.hpp"

namespace furnace {

inline constexpr double kPxPerMetre = 16;

using testing::GltfBuilder;
using testing::Json;

// 1 m a side round the origin, facing +Z, unlit.
inline GltfBuilder quad_builder(Json node = Json::object()) {
  GltfBuilder builder;
  const float h = 0.5f;
  const int position = builder.add_accessor<float>("VEC3", {-h, -h, 0, h, -h, 0, h, h, 0, -h, h, 0});
  const int normal = builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int indices = builder.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 0, 2, 3});
  builder.add("materials", {{"name", "white"},
                            {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 1}}}},
                            {"extensions", {{"KHR_materials_unlit", Json::object()}}}});
  builder.show(
      {{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}, {"indices", indices}, {"material", 0}},
      std::move(node));
  return builder;
}

// Adds the only animation: from 0 to 2 s, linear.
inline void animate(GltfBuilder& builder, const Json& target, const std::string& type,
                    const std::vector<float>& values, const std::string& interpolation = "LINEAR") {
  const int input = builder.add_accessor<float>("SCALAR", {0, 2});
  const int output = builder.add_accessor<float>(type, values);
  builder.add("animations",
              {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
               {"channels", {{{"sampler", 0}, {"target", target}}}}});
}
inline Json pointer_target(const std::string& pointer) {
  return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
}

// Along X from -1 m to 1 m.
inline GltfBuilder moving_quad() {
  GltfBuilder builder = quad_builder();
  animate(builder, {{"node", 0}, {"path", "translation"}}, "VEC3", {-1, 0, 0, 1, 0, 0});
  return builder;
}
// The same by a morph target, and by a joint.
inline GltfBuilder morphing_quad() {
  GltfBuilder builder = quad_builder();
  const int moved = builder.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0});
  testing::primitive_of(builder)["targets"] = {{{"POSITION", moved}}};
  animate(builder, {{"node", 0}, {"path", "weights"}}, "SCALAR", {-1, 1});
  return builder;
}
inline GltfBuilder skinned_quad() {
  GltfBuilder builder = quad_builder({{"skin", 0}});
  Json& attributes = testing::primitive_of(builder)["attributes"];
  attributes["JOINTS_0"] = builder.add_accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(16, 0));
  attributes["WEIGHTS_0"] =
      builder.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  builder.add("nodes", {{"name", "joint"}});
  builder.add("skins", {{"joints", {1}}});
  builder.add("scenes", {{"nodes", {0, 1}}});
  animate(builder, {{"node", 1}, {"path", "translation"}}, "VEC3", {-1, 0, 0, 1, 0, 0});
  return builder;
}

// In the dark, in the middle of its way, which takes a metre a second.
inline RenderSpec moving_spec(const GltfBuilder& builder, int samples, double shutter_s) {
  RenderSpec spec;
  spec.scene.model = std::make_shared<const ModelBundle>(builder.bundle());
  spec.scene.animations = {{0, {1, false}}};
  spec.environment.map = EnvironmentColor{glm::vec3(0)};
  LookAtCamera camera{{0, 0, 3}, {0, 0, 0}};
  camera.height_m = 4;
  spec.camera.view = camera;
  spec.camera.motion.shutter_s = shutter_s;
  spec.output.width = spec.output.height = 64;
  spec.output.samples = samples;
  spec.output.format = OutputFormat::kExr;
  spec.output.exr_type = SampleType::kFloat32;
  return spec;
}

}  // namespace furnace
