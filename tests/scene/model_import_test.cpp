// OBJ, STL and PLY as scenes: geometry by closed forms, materials by their formulas, bounds by files that break them.
#include "renderer/scene/model_import.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/image/color.hpp"
#include "renderer/image/encode.hpp"
#include "renderer/scene/model_material.hpp"
#include "renderer/scene/model_surface.hpp"
#include "tests/scene/model_scenes.hpp"
#include "tests/support/model_files.hpp"

namespace furnace {
namespace {

using namespace test;
double area(const Scene& scene) {
  double sum = 0;
  for (const SharedMesh& mesh : scene.meshes)
    for (std::size_t i = 0; i + 2 < mesh->indices.size(); i += 3) {
      const glm::vec3 a = mesh->positions[mesh->indices[i]];
      sum += 0.5 * glm::length(glm::cross(mesh->positions[mesh->indices[i + 1]] - a,
                                          mesh->positions[mesh->indices[i + 2]] - a));
    }
  return sum;
}

std::string png_of(const std::array<int, 3>& color) {
  Image image = make_image({4, 4}, 3, SampleType::kUint8, ColorSpace::kNonColor);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = std::byte(color[i % 3]);
  return encode_png(image, {});
}

TEST(ModelImport, EveryFormOfPlyIsTheSameSquare) {
  for (const PlyForm form : {PlyForm::kText, PlyForm::kLittle, PlyForm::kBig}) {
    const Scene scene = import_text(ply_square(form));
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = *scene.meshes[0];
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_NEAR(area(scene), 4, 1e-6);
    for (const glm::vec3& normal : mesh.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    for (const glm::vec4& color : mesh.colors) {
      EXPECT_NEAR(color.r, linear_from_srgb(188 / 255.0), 1e-6);
      EXPECT_EQ(color.g, 0);
      EXPECT_NEAR(
          color.a,
          mesh.positions[std::size_t(&color - mesh.colors.data())] == glm::vec3(0, 2, 0) ? 128 / 255.0 : 1,
          1e-6);
    }
    EXPECT_EQ(scene.materials.at(0).base_color,
              glm::vec4(1));  // the colours of the vertices stand in its place
    EXPECT_TRUE(has_note(scene, "normals-generated"));
  }
}

TEST(ModelImport, ACloudIsPoints) {
  const Scene scene = import_text(ply_cloud());
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0]->topology, Topology::kPoints);
  EXPECT_EQ(scene.meshes[0]->indices.size(), 3u);
  EXPECT_EQ(scene.meshes[0]->colors.at(1), glm::vec4(0, 1, 0, 1));
  EXPECT_TRUE(scene.notes.empty());
}

TEST(ModelImport, SplatsAreToldToBePoints) {
  const std::string cloud =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n";
  EXPECT_FALSE(has_note(import_text(cloud + "end_header\n1 2 3 0 0 0\n"), "geometry-ignored"));
  EXPECT_TRUE(has_note(import_text(cloud + "property float scale_0\nend_header\n1 2 3 0 0 0 -4\n"),
                       "geometry-ignored"));
}

TEST(ModelImport, StlIsFlatByItsCornersAndZIsUp) {
  const Scene scene = import_text(binary_stl("solid but binary", {0, 0, 0}));
  const Mesh& mesh = *scene.meshes.at(0);
  EXPECT_EQ(mesh.indices.size(), 9u);
  EXPECT_TRUE(mesh.colors.empty());
  for (const glm::vec3& normal : mesh.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.instances.at(0).world_from_model * glm::vec4(1, 2, 3, 1), glm::vec4(1, 3, -2, 1));
  EXPECT_TRUE(has_note(scene, "up-axis-assumed"));

  const Scene stated = import_text(text_stl(), {}, UpAxis::kY);
  EXPECT_EQ(stated.instances.at(0).world_from_model, glm::mat4(1));
  EXPECT_EQ(stated.meshes.at(0)->normals.at(0), glm::vec3(0, -1, 0));
  EXPECT_NEAR(area(stated), 3, 1e-6);
  EXPECT_TRUE(stated.notes.empty());
}

// 15 bits of colour; bit 15 and the order of the channels mean the opposite in the two conventions.
TEST(ModelImport, StlHasTwoConventionsOfColour) {
  constexpr std::uint16_t kMark = 0x8000, kLow = 31, kHigh = 31 << 10;
  const auto colors_of = [](const Scene& scene) {
    std::array<glm::vec4, 3> colors;
    const Mesh& mesh = *scene.meshes.at(0);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      if (mesh.positions[i].x > 0) colors.at(std::size_t(mesh.positions[i].x) - 1) = mesh.colors.at(i);
    return colors;
  };
  const glm::vec4 red(1, 0, 0, 1), green(0, 1, 0, 1), blue(0, 0, 1, 1), white(1);
  const auto viscam = colors_of(
      import_text(binary_stl("x", {std::uint16_t(kMark | kLow), std::uint16_t(kMark | kHigh), kLow})));
  EXPECT_EQ(viscam, (std::array{blue, red, white}));
  const std::string head("COLOR=\x00\xff\x00\xff", 10);
  const auto magics = colors_of(import_text(binary_stl(head, {kLow, kHigh, std::uint16_t(kMark | kLow)})));
  EXPECT_EQ(magics, (std::array{red, blue, green}));
}

TEST(ModelImport, MtlBecomesMetallicRoughness) {
  const Scene scene = import_text(obj_corner(), {{"corner.mtl", mtl_corner()},
                                                 {"my paint.png", png_of({200, 0, 0})},
                                                 {"bump.png", png_of({128, 128, 255})}});
  ASSERT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.materials.size(), 2u);
  const Material& full = scene.materials[0];
  EXPECT_EQ(full.name, "full");
  EXPECT_EQ(full.base_color, glm::vec4(1, 1, 1, 0.5f));  // map_Kd in place of Kd
  EXPECT_EQ(full.alpha_mode, AlphaMode::kBlend);
  EXPECT_NEAR(full.perceptual_roughness, std::sqrt(std::sqrt(0.02)), 1e-6);
  EXPECT_EQ(full.metallic, 0);
  EXPECT_EQ(full.emissive.r, 2);
  EXPECT_NEAR(full.emissive.g, linear_from_srgb(0.5), 1e-6);
  ASSERT_TRUE(full.texture(TextureUse::kBaseColor) && full.texture(TextureUse::kNormal));
  EXPECT_EQ(scene.images.size(), 2u);
  const Material& metal = scene.materials[1];
  EXPECT_EQ(metal.metallic, 1);
  EXPECT_EQ(metal.perceptual_roughness, 0.25f);
  EXPECT_NEAR(metal.base_color.r, linear_from_srgb(0.5), 1e-6);
  EXPECT_EQ(metal.alpha_mode, AlphaMode::kOpaque);
  EXPECT_TRUE(has_note(scene, "texture-ignored"));  // map_Ks
  EXPECT_FALSE(has_note(scene, "image-missing"));

  const Mesh& back = *scene.meshes[0];
  EXPECT_EQ(scene.instances[0].node_name, "back");
  EXPECT_EQ(back.tangents.size(), back.positions.size());
  for (std::size_t i = 0; i < back.positions.size(); ++i)
    EXPECT_EQ(back.uvs[0].at(i), glm::vec2(back.positions[i].x, 1 - back.positions[i].y));
  // Squares that meet at a right angle keep their edge.
  for (const glm::vec3& n : scene.meshes[1]->normals)
    EXPECT_EQ(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1) << n.x << " " << n.y << " " << n.z;
}

TEST(ModelImport, WhatIsMissingIsTold) {
  const Scene bare = import_text(obj_corner());
  EXPECT_TRUE(has_note(bare, "materials-missing"));
  const Scene scene =
      import_text(obj_corner(), {{"corner.mtl", mtl_corner()}, {"bump.png", png_of({90, 90, 90})}});
  EXPECT_TRUE(has_note(scene, "image-missing"));
  EXPECT_FALSE(scene.materials.at(0).texture(TextureUse::kBaseColor));
  EXPECT_FALSE(scene.materials.at(0).texture(TextureUse::kNormal));  // grey: heights
  EXPECT_NEAR(scene.materials.at(0).base_color.g, linear_from_srgb(0.25), 1e-6);
}

TEST(ModelImport, MaterialsMayHaveAnyName) {
  for (const std::string name : {"model.obj", "a b.mtl", ".mtl"}) {
    const Scene scene = import_text("mtllib " + name + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n",
                                    {{name, "newmtl red\nKd 1 0 0\n"}});
    ASSERT_EQ(scene.materials.size(), 1u) << name;
    EXPECT_EQ(scene.materials[0].base_color, glm::vec4(1, 0, 0, 1)) << name;
  }
}

TEST(ModelImport, VertexColoursLinesAndPointsOfObj) {
  const Scene scene = import_text("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\ng wire\nl 1 2 3\n");
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0]->colors.size(), 3u);
  EXPECT_EQ(scene.meshes[1]->topology, Topology::kLines);
  EXPECT_EQ(scene.meshes[1]->indices.size(), 4u);
}

TEST(ModelImport, EachVertexOfObjHasItsOwnColour) {
  constexpr std::string_view kFace = "f 1 2 3\n";
  const auto colors_of = [&](std::string_view vertices) {
    const Scene scene = import_text(std::string(vertices) + std::string(kFace));
    EXPECT_EQ(scene.meshes.size(), 1u);
    std::vector<glm::vec4> colors(3, glm::vec4(-1));
    const Mesh& mesh = *scene.meshes.at(0);
    for (std::size_t i = 0; i < mesh.colors.size(); ++i)
      colors.at(mesh.positions[i].x > 0.5f ? 1 : mesh.positions[i].y > 0.5f ? 2 : 0) = mesh.colors[i];
    return colors;
  };
  const glm::vec4 red(1, 0, 0, 1), green(0, 1, 0, 1), white(1);
  using testing::ElementsAre;
  EXPECT_THAT(colors_of("v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0\n"), ElementsAre(white, red, green));
  EXPECT_THAT(colors_of("v 0 0 0 255 0 0\nv 2 0 0 2 # heavy\r\nv 0 +1 0 0 255 0\n"),
              ElementsAre(red, white, green));
  EXPECT_THAT(colors_of("v 0 0 0 1 0 0 0.5\nv 1 0 0 0 1 0 1\nv 0 1 0 1 0 0 1\n"),
              ElementsAre(red, green, red));
  EXPECT_THAT(colors_of("v 0 0 0\nv 1 \\\r\n0 0 1 0 0\nv 0 1 \\\n 0 0 1 0\n"),
              ElementsAre(white, red, green));
  const Scene cloud = import_text("v 0 -1e-500 0 # 2\nv 1 0 0 1 0 0\n");
  EXPECT_THAT(cloud.meshes.at(0)->colors, ElementsAre(white, red));
  EXPECT_EQ(import_text("v 0 0 \\\n0\nv 1 0 0\n").meshes.at(0)->positions.size(), 2u);
  EXPECT_THAT(error_of("v 0 0\nv 1 0 0\nv 0 1 0\n" + std::string(kFace)).message,
              testing::HasSubstr("vertex 1 has 2 of its 3 numbers"));
  EXPECT_THAT(error_of("v 0 0 0\nv 1 0 0 1 1\nv 0 1 0\n" + std::string(kFace)).message,
              testing::HasSubstr("vertex 2 has 5 numbers"));
}

// On a sphere the exact normal is the position: what is made must come close, and closer with more triangles.
TEST(ModelImport, GeneratedNormalsAreThoseOfTheSphere) {
  Mesh sphere;
  constexpr int kRings = 24, kSectors = 48;
  constexpr double kPi = 3.14159265358979;
  const auto at = [](int ring, int sector) {
    if (ring == kRings) return glm::vec3(0, -1, 0);
    const double t = kPi * ring / kRings, p = 2 * kPi * (sector % kSectors) / kSectors;
    return glm::vec3(glm::dvec3(std::sin(t) * std::cos(p), std::cos(t), -std::sin(t) * std::sin(p)));
  };
  for (int r = 0; r < kRings; ++r)
    for (int s = 0; s < kSectors; ++s)
      for (const glm::vec3& p :
           {at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s), at(r + 1, s + 1), at(r, s + 1)})
        sphere.positions.push_back(p);
  sphere.indices.resize(sphere.positions.size());
  std::iota(sphere.indices.begin(), sphere.indices.end(), 0u);
  generate_smooth_normals(sphere);
  double worst = 1;
  for (std::size_t i = 0; i < sphere.positions.size(); ++i)
    worst = std::min(worst, double(glm::dot(sphere.normals[i], glm::normalize(sphere.positions[i]))));
  EXPECT_GT(worst, std::cos(0.02));
  EXPECT_EQ(sphere.positions.size(), std::size_t((kRings - 1) * kSectors + 2));
}

TEST(ModelImport, LimitsAndErrorsHaveAPlace) {
  ImportLimits few;
  few.max_triangles = 2;
  EXPECT_EQ(error_of(binary_stl("x", {0, 0, 0}), few).code, ErrorCode::kTooLarge);
  EXPECT_EQ(error_of(obj_corner(), few).code, ErrorCode::kTooLarge);
  ImportLimits small;
  small.max_vertices = 3;
  EXPECT_EQ(error_of(ply_square(PlyForm::kText), small).code, ErrorCode::kTooLarge);
  ImportLimits narrow;
  narrow.max_mesh_bytes = 100;
  EXPECT_EQ(error_of(ply_cloud(), narrow).code, ErrorCode::kTooLarge);
  std::string hollow = binary_stl("x", {0, 0, 0}).substr(0, 84);
  hollow[80] = 0;
  EXPECT_EQ(error_of(hollow).pointer, "/scene/model");
  std::string liar = ply_cloud();
  liar.replace(liar.find("vertex 3"), 8, "vertex 4000000000");
  EXPECT_EQ(error_of(liar).code, ErrorCode::kUnprocessable);
  std::string infinite = binary_stl("x", {0, 0, 0});
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(infinite.data() + 96, &nothing, sizeof nothing);
  EXPECT_EQ(error_of(infinite).code, ErrorCode::kUnprocessable);
}

TEST(ModelImport, NormalMapsAreToldFromHeights) {
  const auto looks = [](int r, int g, int b) {
    Image image = make_image({2, 2}, 3, SampleType::kUint8, ColorSpace::kNonColor);
    for (std::size_t i = 0; i < 4; ++i) {
      image.pixels[3 * i] = std::byte(r);
      image.pixels[3 * i + 1] = std::byte(g);
      image.pixels[3 * i + 2] = std::byte(b);
    }
    return looks_like_normal_map(image);
  };
  EXPECT_TRUE(looks(128, 128, 255));
  EXPECT_TRUE(looks(140, 120, 250));
  for (const int grey : {0, 64, 128, 201, 255}) EXPECT_FALSE(looks(grey, grey, grey)) << grey;
}

// Whatever a child may say is judged by one function: no damage to an honest answer gets past it unsound.
TEST(PlainModelCheck, SeesThroughLies) {
  const PlainModel honest = decode_model(Blob(ply_square(PlyForm::kText)), "", ModelFormat::kPly, {});
  ASSERT_TRUE(is_sound(honest, {}));
  const auto lie = [&](auto&& damage) {
    PlainModel model = honest;
    damage(model);
    return is_sound(model, {});
  };
  EXPECT_FALSE(lie([](PlainModel& m) { m.indices[0] = 4; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.indices.pop_back(); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.positions[0].x = std::numeric_limits<float>::infinity(); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.positions.emplace_back(0); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.normals[1] = glm::vec3(0); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.normals.clear(); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.colors[1].g = 2; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.parts[0].has_uvs = 1; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.parts[0].topology = 3; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.parts[0].material = 1; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.parts[0].vertices = ~0u; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.parts.push_back(m.parts[0]); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.parts.clear(); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.materials[0].name.size = ~0u; }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.materials[0].opacity = std::nanf(""); }));
  EXPECT_FALSE(lie([](PlainModel& m) { m.materials[0].exponent = -1; }));
  EXPECT_FALSE(is_sound(honest, {.max_vertices = 3}));
  EXPECT_FALSE(is_sound(honest, {.max_elements = 1}));
}

}  // namespace
}  // namespace furnace
