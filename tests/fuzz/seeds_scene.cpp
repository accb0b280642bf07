// Documents of the glTF tests, compressed meshes, models of other formats, luminaires.
#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>

#include "tests/fuzz/seeds.hpp"
#include "tests/scene/draco_grid.hpp"
#include "tests/scene/gltf_samples.hpp"
#include "tests/scene/meshopt_files.hpp"
#include "tests/support/model_files.hpp"

namespace furnace::fuzz {
namespace {

using furnace::testing::GltfBuilder;
using furnace::testing::Json;

// Turns, moves, scales and bends; the second clip by a pointer, in steps.
GltfBuilder animated_builder() {
  GltfBuilder builder = furnace::testing::clean_builder({{"name", "a node"}});
  const int morph = builder.add_accessor<float>("VEC3", {0, 0, 0, 0, 0, 0, 0, 0, 1});
  furnace::testing::primitive_of(builder)["targets"] = {{{"POSITION", morph}}};
  const int times = builder.add_accessor<float>("SCALAR", {0, 0.5f, 1});
  const int places = builder.add_accessor<float>("VEC3", {0, 0, 0, 1, 2, 3, 0, 0, 0});
  const int turns =
      builder.add_accessor<std::int16_t>("VEC4", {0, 0, 0, 32767, 0, 0, 32767, 0, 0, 0, 0, 32767}, true);
  const int weights = builder.add_accessor<float>("SCALAR", {0, 0, 1, 0, 1, 0, 1, 0, 0});
  const int visible = builder.add_accessor<std::uint8_t>("SCALAR", {1, 0, 1});
  const auto channel = [](int sampler, const char* path) {
    return Json{{"sampler", sampler}, {"target", {{"node", 0}, {"path", path}}}};
  };
  builder.add("animations",
              {{"name", "move"},
               {"samplers",
                {{{"input", times}, {"output", places}},
                 {{"input", times}, {"output", turns}, {"interpolation", "LINEAR"}},
                 {{"input", times}, {"output", weights}, {"interpolation", "CUBICSPLINE"}}}},
               {"channels", {channel(0, "translation"), channel(1, "rotation"), channel(2, "weights")}}});
  const Json target = {
      {"path", "pointer"},
      {"extensions",
       {{"KHR_animation_pointer", {{"pointer", "/nodes/0/extensions/KHR_node_visibility/visible"}}}}}};
  builder.add("animations",
              {{"samplers", {{{"input", times}, {"output", visible}, {"interpolation", "STEP"}}}},
               {"channels", {{{"sampler", 0}, {"target", target}}}}});
  builder.json["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = true;
  builder.json["extensionsUsed"] = {"KHR_animation_pointer", "KHR_node_visibility"};
  return builder;
}

GltfBuilder instanced_builder() {
  GltfBuilder builder = furnace::testing::clean_builder();
  const int places = builder.add_accessor<float>("VEC3", {1, 0, 0, 0, 2, 0});
  const int scales = builder.add_accessor<float>("VEC3", {1, 1, 1, 3, 3, 3});
  const int turns = builder.add_accessor<std::int8_t>("VEC4", {0, 0, 0, 127, 0, 0, 127, 0}, true);
  builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", scales}};
  return builder;
}

std::vector<ModelBundle> bundles() {
  std::vector<ModelBundle> all = {furnace::testing::rich_bundle()};
  for (const GltfBuilder& builder :
       {furnace::testing::furnished_builder(), animated_builder(), instanced_builder(),
        furnace::testing::grid_document(true), furnace::testing::grid_document(false),
        furnace::testing::triangle_builder()})
    all.push_back(builder.bundle());
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    all.push_back(
        furnace::testing::with_placeholder(furnace::testing::compressed_triangle(name), Json::object()));
  return all;
}

std::string glb_of(const ModelBundle& bundle) {
  Json document = Json::parse(bundle.document.text());
  if (document.contains("buffers")) document["buffers"][0].erase("uri");
  std::string json = document.dump(), binary(bundle.siblings.at("data.bin").text());
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  return "glTF" + number(2, 4) + number(std::uint32_t(28 + json.size() + binary.size()), 4) +
         number(std::uint32_t(json.size()), 4) + "JSON" + json + number(std::uint32_t(binary.size()), 4) +
         std::string("BIN\0", 4) + binary;
}

// The fields of accessor_bundle (gltf_targets.cpp), with views that hold what they must.
std::string accessor_input(unsigned flags, unsigned component, unsigned type, unsigned stride) {
  constexpr unsigned kCount = 5;
  std::string input = number(flags, 1) + number(component, 1) + number(type, 1) + number(kCount, 2);
  if (flags & 1) input += number(4, 2);
  if (flags & 4) input += number(2, 2) + number(1, 1) + number(0, 2) + number(0, 2);
  input += number(0, 2) + number(400, 2) + number(stride, 1);  // elements
  input += number(400, 2) + number(8, 2) + number(0, 1);       // sparse indices
  input += number(408, 2) + number(160, 2) + number(0, 1);     // sparse values
  std::string buffer;
  for (unsigned i = 0; i < 400; ++i) buffer += char(i * 37 % 251);
  buffer += number(1, 1) + number(3, 1) + std::string(6, '\0');
  for (unsigned i = 0; i < 160; ++i) buffer += char(i * 91 % 241);
  return input + buffer;
}

void add_accessors(std::vector<std::string>& inputs) {
  for (unsigned component = 0; component < 6; ++component) {
    for (unsigned type = 0; type < 7; ++type) {
      inputs.push_back(accessor_input(component % 2 == 0 ? 5 : 1, component, type, type < 4 ? 20 : 64));
      if (component < 4) inputs.push_back(accessor_input(type % 2 == 0 ? 7 : 6, component, type, 0));
    }
  }
}

// The fields of run_draco (mesh_targets.cpp).
std::string draco_input(bool edgebreaker) {
  return number(2, 1) + number(0, 1) + number(5, 1) + number(2, 1) + number(1, 1) + number(1, 1) +
         number(3, 1) + number(furnace::testing::kVertices, 2) + number(furnace::testing::kTriangles, 2) +
         furnace::testing::encoded_grid(edgebreaker);
}

// The fields of run_meshopt (mesh_targets.cpp).
std::string meshopt_input(unsigned mode, unsigned filter, std::size_t stride, std::size_t count,
                          const furnace::testing::Bytes& file) {
  return number(mode, 1) + number(filter, 1) + number(std::uint32_t(stride), 2) +
         number(std::uint32_t(count), 2) + std::string(file.begin(), file.end());
}

void add_meshopt(std::vector<std::string>& inputs) {
  for (const std::size_t stride : {4, 8, 12, 16}) {
    for (const std::size_t count : {3, 17, 100}) {
      const auto elements = furnace::testing::sample_elements(count, stride);
      std::vector<std::uint8_t> modes;
      for (std::size_t c = 0; c < stride / 4; ++c)
        modes.push_back(std::array<std::uint8_t, 4>{0, 1, 2, 0x52}[c % 4]);
      const auto first = furnace::testing::encoded_by_library(elements, stride);
      const auto second = furnace::testing::Version1(stride, modes, unsigned(count)).encode(elements);
      for (unsigned filter = 0; filter < 5; ++filter) {
        inputs.push_back(meshopt_input(0, filter, stride, count, filter % 2 == 0 ? first : second));
        if (filter == 0) inputs.push_back(meshopt_input(0, filter, stride, count, second));
      }
    }
  }
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < 40; ++i) indices.insert(indices.end(), {i, i + 1, i + 2 + i % 3});
  furnace::testing::Bytes triangles(meshopt_encodeIndexBufferBound(indices.size(), 64));
  triangles.resize(
      meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), indices.size()));
  furnace::testing::Bytes sequence(meshopt_encodeIndexSequenceBound(indices.size(), 64));
  sequence.resize(
      meshopt_encodeIndexSequence(sequence.data(), sequence.size(), indices.data(), indices.size()));
  for (const std::size_t stride : {2, 4}) {
    inputs.push_back(meshopt_input(1, 0, stride, indices.size(), triangles));
    inputs.push_back(meshopt_input(2, 0, stride, indices.size(), sequence));
  }
}

}  // namespace

void add_gltf_seeds(Seeds& seeds) {
  for (const ModelBundle& bundle : bundles()) {
    seeds["gltf"].push_back(std::string(bundle.document.text()) + '\0' +
                            std::string(bundle.siblings.at("data.bin").text()));
    seeds["glb"].push_back(glb_of(bundle));
  }
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator("tests/scene/corpus"))
    if (entry.path().extension() == ".gltf") paths.push_back(entry.path().string());
  std::ranges::sort(paths);
  for (const std::string& path : paths) seeds["gltf"].push_back(file_text(path));
  seeds["inspect"] = seeds["gltf"];
  add_accessors(seeds["accessor"]);
}

void add_mesh_seeds(Seeds& seeds) {
  seeds["draco"] = {draco_input(true), draco_input(false)};
  add_meshopt(seeds["meshopt"]);
  seeds["obj"] = {test::obj_corner() + '\0' + test::mtl_corner(), test::obj_corner(),
                  "v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0 1\nf 1 2 3\n",
                  "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvn 0 0 1\nf 1//1 2//1 3//1\nl 1 2 3\np 1\n"};
  seeds["stl"] = {test::text_stl(), test::binary_stl("a thing", {0, 0, 0}),
                  test::binary_stl("COLOR=abcd", {1, 0x8000, 77})};
  using enum test::PlyForm;
  seeds["ply"] = {test::ply_square(kText), test::ply_square(kLittle), test::ply_square(kBig),
                  test::ply_cloud()};
  const std::string head = "IESNA:LM-63-2002\r\n[MANUFAC] none\r\n";
  const std::string plain = "1 1000 1 2 3 1 1 0 0 0 1 1 1\n0 180\n0 45 90\n1 1 2 2 3 3\n";
  seeds["ies"] = {head + "TILT=NONE\r\n" + plain, head + "TILT=INCLUDE\n1\n2\n0 90\n1 0.5\n" + plain,
                  head + "TILT=NONE\n1 -1 1.5 3 1 1 2 0 0 0 0.5 1 10\n0 90 180\n0\n40 40 40\n",
                  head + "TILT=NONE\n1 1 1 3 2 2 2 0 0 0 1 1 1\n-90 0 90\n-90 90\n1 2 3 1 2 3\n"};
}

}  // namespace furnace::fuzz
