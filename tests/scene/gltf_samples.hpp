// Documents that give many readers something to do.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/scene/gltf_builder.hpp"

namespace furnace::testing {

// Skin, morph targets, sparse accessor, textures, indices, two UV sets: every reader has something to do.
inline ModelBundle rich_bundle() {
  GltfBuilder builder;
  const int position = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const int normal = builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv = builder.add_accessor<std::uint16_t>("VEC2", {0, 0, 65535, 0, 0, 65535, 65535, 65535}, true);
  const int color = builder.add_accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(16, 200), true);
  const int joints = builder.add_accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(16, 0));
  const int weights = builder.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const int indices = builder.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 2, 1, 3});
  const int morph = builder.add("accessors", {{"type", "VEC3"}, {"componentType", 5126}, {"count", 4}});
  builder.json["accessors"][morph]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", builder.add_view<std::uint8_t>({2})}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.add_view<float>({0, 0, 1})}}}};
  const int image = builder.add(
      "images", {{"bufferView", builder.add_view<std::uint8_t>({0x89, 'P', 'N', 'G', 13, 10, 26, 10})}});
  const int texture = builder.add("textures", {{"source", image}});
  const Json layers = {
      {"KHR_materials_ior", {{"ior", 1.5}}},
      {"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", texture}}}}},
      {"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}},
      {"KHR_materials_volume", {{"attenuationDistance", 1}, {"attenuationColor", {1, 0.5, 1}}}},
      {"KHR_materials_pbrSpecularGlossiness", {{"glossinessFactor", 0.5}}}};
  const int material =
      builder.add("materials", {{"normalTexture", {{"index", texture}}}, {"extensions", layers}});
  builder.json["extensions"]["KHR_materials_variants"]["variants"].push_back({{"name", "a"}});
  const Json mappings = Json::array({{{"material", material}, {"variants", {0}}}});
  const int skin = builder.add(
      "skins", {{"joints", {1}},
                {"inverseBindMatrices",
                 builder.add_accessor<float>("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})}});
  builder.show({{"attributes",
                 {{"POSITION", position},
                  {"NORMAL", normal},
                  {"TEXCOORD_0", uv},
                  {"COLOR_0", color},
                  {"JOINTS_0", joints},
                  {"WEIGHTS_0", weights}}},
                {"indices", indices},
                {"material", material},
                {"extensions", {{"KHR_materials_variants", {{"mappings", mappings}}}}},
                {"targets", {{{"POSITION", morph}}}}},
               {{"skin", skin}, {"weights", {0.5}}});
  builder.add("nodes", {{"translation", {0, 0, 1}}, {"rotation", {0, 0, 0, 1}}});
  builder.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
  builder.add("nodes", {{"camera", 0}});
  return builder.bundle();
}

// A quad twice over, one node outside of the scene, an unused material and camera, two variants, an animation.
inline GltfBuilder furnished_builder() {
  GltfBuilder builder;
  builder.json["asset"]["generator"] = "by hand";
  builder.json["asset"]["copyright"] = "nobody";
  const int position = builder.add_accessor<float>("VEC3", {0, 0, 0, 2, 0, 0, 0, 3, 0, 2, 3, 0});
  builder.json["accessors"][position]["min"] = {0, 0, 0};
  builder.json["accessors"][position]["max"] = {2, 3, 1};  // too large: declared is not what is
  const int normal = builder.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv = builder.add_accessor<std::uint16_t>("VEC2", {0, 0, 65535, 0, 0, 65535, 65535, 65535}, true);
  const int indices = builder.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 2, 1, 3});
  const int times = builder.add_accessor<float>("SCALAR", {0, 0.5f, 1.25f});
  const int places = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 2, 0, 0});
  const int texture = add_texture(builder, "color.png");
  add_texture(builder, "gone.png");
  builder.add("materials", {{"name", "wood"},
                            {"alphaMode", "MASK"},
                            {"doubleSided", true},
                            {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}},
                            {"extensions", {{"KHR_materials_ior", {{"ior", 1.4}}}}}});
  builder.add("materials", {{"name", "spare"}, {"normalTexture", {{"index", texture}}}});
  builder.json["extensionsUsed"] = {"KHR_materials_ior", "KHR_materials_variants", "MY_extension"};
  builder.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "day"}}, {{"name", "night"}}};
  builder.show({{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}},
                {"indices", indices},
                {"material", 0}},
               {{"name", "first"}});
  builder.add("nodes", {{"mesh", 0}, {"translation", {10, 0, 0}}, {"children", {2}}});
  builder.add("nodes", {{"name", "child"}});
  builder.add("nodes", {{"name", "outside"}, {"camera", 0}});
  builder.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.5}}}});
  builder.add("scenes", {{"name", "main"}, {"nodes", {0, 1}}});
  builder.add("scenes", {{"nodes", {1}}});
  builder.json["scene"] = 0;
  builder.add("animations",
              {{"name", "slide"},
               {"samplers", {{{"input", times}, {"output", places}, {"interpolation", "STEP"}}}},
               {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
  return builder;
}

}  // namespace furnace::testing
