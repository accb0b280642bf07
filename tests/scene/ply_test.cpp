// PLY: one model in every encoding and type, strips by their areas, and what is wrong by name.
#include <array>
#include <chrono>
#include <cstring>
#include <random>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/plain_model.hpp"
#include "renderer/scene/scene.hpp"
#include "tests/support/ply_writer.hpp"

namespace furnace {
namespace {

using namespace test;

constexpr std::array kForms = {PlyForm::kText, PlyForm::kLittle, PlyForm::kBig};

PlainModel decode(const std::string& file, const PlainModelLimits& limits = {}) {
  PlainModel model = decode_model(std::as_bytes(std::span(file)), "", ModelFormat::kPly, limits);
  EXPECT_TRUE(is_sound(model, limits));
  return model;
}

Error error_of(const std::string& file, const PlainModelLimits& limits = {}) {
  try {
    decode(file, limits);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

// Vector areas of all triangles and the volume they enclose, seen from the origin.
struct Measure {
  glm::dvec3 area{0};
  double sum_of_areas = 0, volume = 0;
};

Measure measure(const PlainModel& model) {
  Measure sum;
  std::size_t vertex = 0, index = 0;
  for (const PlainPart& part : model.parts) {
    for (std::size_t i = 0; part.topology == 2 && i < part.indices; i += 3) {
      glm::dvec3 p[3];
      for (std::size_t k = 0; k < 3; ++k) p[k] = model.positions[vertex + model.indices[index + i + k]];
      const glm::dvec3 area = glm::cross(p[1] - p[0], p[2] - p[0]) * 0.5;
      sum.area += area;
      sum.sum_of_areas += glm::length(area);
      sum.volume += glm::dot(p[0], glm::cross(p[1], p[2])) / 6;
    }
    vertex += part.vertices;
    index += part.indices;
  }
  return sum;
}

template <class Value>
bool same(const std::vector<Value>& a, const std::vector<Value>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

bool same(const PlainModel& a, const PlainModel& b) {
  return same(a.text, b.text) && same(a.parts, b.parts) && same(a.positions, b.positions) &&
         same(a.normals, b.normals) && same(a.uvs, b.uvs) && same(a.colors, b.colors) &&
         same(a.indices, b.indices);
}

// The cube of side 1 at the origin, with unknown things before, between and behind, and its faces before its vertices.
std::string cube(PlyForm form, std::string_view line_end, std::string_view real = "float",
                 std::string_view count = "uchar", std::string_view integer = "int") {
  static constexpr std::uint32_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                 {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  PlyWriter out(form, line_end);
  out.line("comment made for a test").line("obj_info of a cube").line("Created by hand").line("");
  out.line("element camera 1").line("property float fov").line("property list uchar double path");
  out.line("element face 6").line("property uchar flags");
  out.line(fmt::format("property list {} {} vertex_indices", count, integer));
  out.line("property list ushort short edges");
  out.line("element vertex 8").line(fmt::format("property {} x", real)).line("property double weight");
  out.line(fmt::format("property {} y", real)).line(fmt::format("property {} z", real));
  out.line("element nothing 4000000000").line("element end 1").line("property int last").line("end_header");
  out.put("float", 0.75).put_list("uchar", "double", std::array{0.5, 1e300, -3.0});
  for (const auto& face : kFaces) {
    out.put("uchar", 7).put_list(count, integer, std::span(face));
    out.put_list("ushort", "short", std::vector<int>(std::size_t(face[0]), -1));
  }
  for (int i = 0; i < 8; ++i)
    out.put(real, i & 1).put("double", -1e-300).put(real, (i >> 1) & 1).put(real, i >> 2);
  out.put("int", 10);
  return out.file();
}

TEST(Ply, ACubeIsTheSameInEveryEncodingAndLineEnd) {
  const PlainModel cube_of_text = decode(cube(PlyForm::kText, "\n"));
  EXPECT_EQ(cube_of_text.positions.size(), 24u);  // its edges are sharp
  EXPECT_EQ(cube_of_text.indices.size(), 36u);
  const Measure m = measure(cube_of_text);
  EXPECT_NEAR(m.volume, 1, 1e-12);
  EXPECT_NEAR(m.sum_of_areas, 6, 1e-12);
  for (const PlyForm form : kForms)
    for (const std::string_view line_end : {"\n", "\r\n", "\r"})
      EXPECT_TRUE(same(decode(cube(form, line_end)), cube_of_text)) << int(form) << int(line_end[0]);
}

TEST(Ply, EveryTypeHoldsNumbersCountsAndIndices) {
  const PlainModel expected = decode(cube(PlyForm::kText, "\n"));
  for (const PlyForm form : kForms)
    for (const std::string_view type :
         {"char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8", "uint8", "int16",
          "uint16", "int32", "uint32", "float32", "float64"})
      EXPECT_TRUE(same(decode(cube(form, "\n", type, type, type)), expected)) << int(form) << type;
}

// The extremes of each type, told by the bounds of a cloud.
TEST(Ply, NumbersAreTakenExactly) {
  struct Range {
    std::string_view type;
    double low, high;
  };
  static constexpr Range kRanges[] = {{"char", -128, 127},           {"uchar", 0, 255},
                                      {"short", -32768, 32767},      {"ushort", 0, 65535},
                                      {"int", -2147483648.0, 65536}, {"uint", 0, 4294967040.0},
                                      {"float", -1.5e30, 0x1p-149},  {"double", -0.125, 1e-300}};
  for (const PlyForm form : kForms) {
    PlyWriter out(form);
    out.line("element vertex 8");
    for (const char* name : {"x", "y", "z"}) out.line(fmt::format("property double {}", name));
    for (const Range& range : kRanges)
      out.line(fmt::format("element {} 1", range.type)).line(fmt::format("property {} p", range.type));
    out.line("end_header");
    for (const Range& range : kRanges)
      out.put("double", range.low).put("double", range.high).put("double", 0);
    for (const Range& range : kRanges) out.put(range.type, range.high);
    const PlainModel model = decode(out.file());
    ASSERT_EQ(model.positions.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_EQ(model.positions[i], glm::vec3(kRanges[i].low, kRanges[i].high, 0)) << kRanges[i].type;
    for (const Range& range : kRanges) {
      PlyWriter one(form);
      one.line("element vertex 1");
      for (const char* name : {"x", "y", "z"}) one.line(fmt::format("property {} {}", range.type, name));
      one.line("end_header").put(range.type, range.low).put(range.type, range.high).put(range.type, 0);
      EXPECT_EQ(decode(one.file()).positions.at(0), glm::vec3(range.low, range.high, 0)) << range.type;
    }
  }
}

std::string text_ply(const std::string& vertex_properties, const std::vector<std::string>& vertices,
                     const std::string& more_header = "", const std::string& more_body = "") {
  std::string out = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n{}{}"
      "end_header\n",
      vertices.size(), vertex_properties, more_header);
  for (const std::string& vertex : vertices) out += vertex + "\n";
  return out + more_body;
}

const std::vector<std::string> kSquare = {"0 0 0", "1 0 0", "1 1 0", "0 1 0"};
const std::string kFaces = "property list uchar int vertex_index\n";

TEST(Ply, NumbersOfTextMayBeWrittenInEveryWay) {
  const PlainModel model = decode("\xef\xbb\xbf" + text_ply("", {"+1 -1.50 1e3", ".5\t5.\r\n1E-999"}));
  ASSERT_EQ(model.positions.size(), 2u);
  EXPECT_EQ(model.positions[0], glm::vec3(1, -1.5, 1000));
  EXPECT_EQ(model.positions[1], glm::vec3(0.5, 5, 0));
}

TEST(Ply, StripsTurnEveryOtherTriangle) {
  const Measure m = measure(decode(text_ply("", {"0 0 0", "0 1 0", "1 0 0", "1 1 0", "2 0 0", "2 1 0"},
                                            "element tristrips 2\nproperty list int int vertex_indices\n",
                                            "6 1 0 3 2 5 4\n6 -1 1 0 3 3 -1\n")));
  EXPECT_NEAR(m.area.z, 2.5, 1e-12);
  EXPECT_NEAR(m.sum_of_areas, 2.5, 1e-12);
}

TEST(Ply, EdgesAreLinesAndVerticesAloneAreACloud) {
  const std::string edges =
      "element edge 2\nproperty int vertex1\nproperty int vertex2\nproperty uchar red\n";
  const PlainModel wire = decode(text_ply("", kSquare, edges, "0 1 9\n2 2 9\n"));
  ASSERT_EQ(wire.parts.size(), 1u);
  EXPECT_EQ(wire.parts[0].topology, std::uint32_t(Topology::kLines));
  EXPECT_EQ(wire.indices.size(), 2u);
  const PlainModel cloud = decode(text_ply("", kSquare, "element face 0\n" + kFaces));
  EXPECT_EQ(cloud.parts.at(0).topology, std::uint32_t(Topology::kPoints));
  EXPECT_EQ(cloud.positions.size(), 4u);
  const PlainModel mixed =
      decode(text_ply("", kSquare, "element face 4\n" + kFaces, "3 0 1 2\n2 2 3\n1 3\n0\n"));
  ASSERT_EQ(mixed.parts.size(), 3u);
  EXPECT_EQ(mixed.indices.size(), 3u + 2 + 1);
}

TEST(Ply, ColoursFollowTheirTypes) {
  const auto first_color = [](const std::string& properties, const std::string& values) {
    return decode(text_ply(properties, {"0 0 0 " + values})).colors.at(0);
  };
  const auto rgb = [](const std::string& type, std::array<const char*, 3> names) {
    std::string out;
    for (const char* name : names) out += fmt::format("property {} {}\n", type, name);
    return out;
  };
  const std::array kNames = {"red", "green", "blue"};
  EXPECT_EQ(first_color(rgb("uchar", kNames), "255 0 51"), glm::vec4(1, 0, 0.2f, 1));
  EXPECT_EQ(first_color(rgb("ushort", {"r", "g", "b"}), "65535 0 13107"), glm::vec4(1, 0, 0.2f, 1));
  EXPECT_EQ(first_color(rgb("int", {"diffuse_red", "diffuse_green", "diffuse_blue"}), "255 0 51"),
            glm::vec4(1, 0, 0.2f, 1));
  EXPECT_EQ(first_color(rgb("float", kNames) + "property uchar alpha\n", "1.5 -1 0.2 51"),
            glm::vec4(1, 0, 0.2f, 0.2f));
  // A splat's, in whose name's order; half grey where its harmonics vanish.
  EXPECT_EQ(first_color(rgb("float", {"f_dc_0", "f_dc_1", "f_dc_2"}), "0 9 -9"), glm::vec4(0.5f, 1, 0, 1));
  EXPECT_TRUE(decode(text_ply(rgb("uchar", {"red", "green", "mauve"}), {"0 0 0 1 1 1"})).colors.empty());
}

TEST(Ply, AFaceMayHaveColoursCoordinatesAndATexture) {
  const PlainModel model = decode(text_ply(
      "property float s\nproperty float t\n", {"0 0 0 0 0", "1 0 0 1 0", "1 1 0 1 1", "0 1 0 0 1"},
      "comment TextureFile  skin one.png\ncomment TextureFile two.png\nelement face 3\n"
      "property list uchar float texcoord\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property int texnumber\n" +
          kFaces,
      "0 255 0 0 0 3 0 1 2\n6 0.5 0.25 1 1 1 1 0 255 0 0 3 0 2 3\n0 0 0 255 1 3 0 1 2\n"));
  ASSERT_EQ(model.parts.size(), 2u);
  const auto base = std::size_t(PlainTexture::kBaseColor);
  EXPECT_EQ(model.text_of(model.materials[model.parts[0].material].textures[base]), "skin one.png");
  EXPECT_EQ(model.text_of(model.materials[model.parts[1].material].textures[base]), "two.png");
  ASSERT_EQ(model.positions.size(), 9u);
  const auto expect = [&](std::size_t i, glm::vec3 position, glm::vec2 uv, glm::vec4 color) {
    EXPECT_EQ(model.positions[i], position) << i;
    EXPECT_EQ(model.uvs[i], uv) << i;
    EXPECT_EQ(model.colors[i], color) << i;
  };
  expect(model.indices[1], {1, 0, 0}, {1, 1}, {1, 0, 0, 1});       // the vertex's, upside down
  expect(model.indices[3], {0, 0, 0}, {0.5, 0.75}, {0, 1, 0, 1});  // the corner's
  expect(6 + model.indices[8], {1, 1, 0}, {1, 0}, {0, 0, 1, 1});
}

TEST(Ply, NormalsAreKeptUnlessOneHasNoDirection) {
  const std::string normals = "property float nx\nproperty float ny\nproperty float nz\n";
  const std::string face = "element face 1\n" + kFaces;
  const PlainModel kept = decode(
      text_ply(normals, {"0 0 0 0 3 4", "1 0 0 0 3 4", "1 1 0 0 3 4", "9 9 9 0 0 0"}, face, "3 0 1 2\n"));
  EXPECT_EQ(kept.parts.at(0).made_normals, 0u);
  EXPECT_EQ(kept.normals.at(1), glm::vec3(0, 0.6f, 0.8f));
  const PlainModel made =
      decode(text_ply(normals, {"0 0 0 0 3 4", "1 0 0 0 nan 4", "1 1 0 0 3 4"}, face, "3 0 1 2\n"));
  EXPECT_EQ(made.parts.at(0).made_normals, 1u);
  EXPECT_EQ(made.normals.at(1), glm::vec3(0, 0, 1));
}

// What is wrong is said by row, and by line or byte.
TEST(Ply, ErrorsNameTheirPlace) {
  const std::string face = "element face 2\n" + kFaces;
  const auto message = [](const std::string& file) {
    const Error error = error_of(file);
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    EXPECT_TRUE(error.message.starts_with("is not a readable PLY file: ")) << error.message;
    return error.message.substr(28);
  };
  EXPECT_EQ(message(text_ply("", kSquare, face, "3 0 1 2\n3 0 1 4\n")),
            "face 1 names vertex 4 of 4, in line 15");
  EXPECT_EQ(message(text_ply("", kSquare, face, "3 0 1 2\n3 0 -1 3\n")),
            "face 1 names vertex -1 of 4, in line 15");
  EXPECT_EQ(message(text_ply("", kSquare, face, "3 0 1 2\n3 0 0.5 3\n")),
            "face 1 names vertex 0.5 of 4, in line 15");
  EXPECT_EQ(message(text_ply("", kSquare, face, "3 0 1 2\n\n\n-3 0 1 3\n")),
            "face 1 has a list of -3 values, in line 17");
  EXPECT_EQ(message(text_ply("", kSquare, face, "3 0 1 2\n3 0 1")),
            "face 1 is cut off: a list has 3 values, and 4 bytes are left, in line 15");
  EXPECT_EQ(message(text_ply("", {"0 0 0", "1 nan 0"})), "vertex 1 has a position that is not finite");
  EXPECT_EQ(message(text_ply("", {"0 0 0", "1 1e999 0"})), "vertex 1 has a position that is not finite");
  EXPECT_EQ(message(text_ply("", {"0 0 0", "1 0,5 0"})), "vertex 1 has \"0,5\" for a number, in line 9");
  std::string binary = cube(PlyForm::kLittle, "\n");
  binary.resize(binary.size() - 5);
  EXPECT_EQ(message(binary),
            fmt::format("vertex 7 is cut off: the file ends, at byte {}", binary.size() - 3));
  EXPECT_EQ(message("ply\nformat ascii 1.0\nelement vertex 9999\nproperty char x\nend_header\n1 2 3\n"),
            "it announces 9999 of \"vertex\", and ends after 74 bytes, which hold 3 at most");
  EXPECT_EQ(message("ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n"),
            "\"99999999999999999999\" is no count of elements, in line 3");
  EXPECT_EQ(message("ply\nformat ascii 1.0\nelement vertex 3\nproperty half x\n"),
            "there is no type \"half\", in line 4");
  EXPECT_EQ(message("ply\nformat ascii 2.0\n"), "its version is \"2.0\", not 1.0, in line 2");
  EXPECT_EQ(message("ply\nformat zip 1.0\n"), "there is no format \"zip\", in line 2");
  EXPECT_EQ(message("ply\nend_header\n"), "its header says no format");
  EXPECT_EQ(message("ply\nformat ascii 1.0\n"), "it ends before end_header");
  EXPECT_EQ(message("plywood\n"), "it does not begin with \"ply\"");
  EXPECT_EQ(message(""), "it does not begin with \"ply\"");
  EXPECT_EQ(message("ply\n" + std::string(2 << 20, '\n')), "its header is longer than 1048576 bytes");
  EXPECT_EQ(message("ply\nformat ascii 1.0\nend_header\n"), "it has 0 elements \"vertex\", not one");
  EXPECT_EQ(message(text_ply("", kSquare, "element face 1\nproperty int corner\n", "1\n")),
            "its faces need a list vertex_indices");
  EXPECT_EQ(error_of(text_ply("", {})).code, ErrorCode::kUnprocessable);
}

TEST(Ply, LimitsHoldBeforeMemoryIsTaken) {
  const auto code = [](const std::string& file, const PlainModelLimits& limits) {
    return error_of(file, limits).code;
  };
  const std::string strip =
      text_ply("", kSquare, "element tristrips 1\nproperty list int int vertex_indices\n", "4 0 1 2 3\n");
  const std::string faces = text_ply("", kSquare, "element face 1\n" + kFaces, "4 0 1 2 3\n");
  EXPECT_EQ(code(faces, {.max_vertices = 3}), ErrorCode::kTooLarge);
  EXPECT_EQ(code(faces, {.max_elements = 1}), ErrorCode::kTooLarge);
  EXPECT_EQ(code(strip, {.max_elements = 1}), ErrorCode::kTooLarge);
  EXPECT_EQ(code(text_ply("", kSquare), {.max_elements = 3}), ErrorCode::kTooLarge);
  EXPECT_EQ(code(faces, {.max_bytes = 40}), ErrorCode::kTooLarge);
  EXPECT_EQ(
      code(text_ply("", kSquare, "comment TextureFile a\ncomment TextureFile b\n"), {.max_materials = 1}),
      ErrorCode::kTooLarge);
}

TEST(Ply, TheDeadlineEndsIt) {
  const std::vector<std::string> vertices(40'000, "0 0 0");
  const std::string file = text_ply("", vertices);
  try {
    decode_model(std::as_bytes(std::span(file)), "", ModelFormat::kPly, {},
                 Deadline(std::chrono::milliseconds(0)));
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  }
}

// Damage ends in a model that is sound or in an error of the file's.
bool survives(const std::string& file) {
  PlainModelLimits limits;
  limits.max_bytes = 1 << 20;
  try {
    EXPECT_TRUE(
        is_sound(decode_model(std::as_bytes(std::span(file)), "", ModelFormat::kPly, limits), limits));
    return true;
  } catch (const Error& error) {
    EXPECT_TRUE(error.code == ErrorCode::kUnprocessable || error.code == ErrorCode::kTooLarge)
        << error.message;
    return false;
  }
}

std::vector<std::string> small_files() {
  std::vector<std::string> files;
  for (const PlyForm form : kForms) {
    files.push_back(ply_square(form));
    files.push_back(cube(form, "\n", "short", "int", "double"));
  }
  files.push_back(
      text_ply("", kSquare, "element tristrips 1\nproperty list int int vertex_indices\n", "5 0 1 2 -1 3\n"));
  files.push_back(text_ply("", kSquare,
                           "comment TextureFile a.png\nelement face 1\nproperty list uchar float texcoord\n" +
                               kFaces + "element edge 1\nproperty int vertex1\nproperty int vertex2\n",
                           "8 0 0 1 0 1 1 0 1 4 3 0 2 1\n0 1\n"));
  return files;
}

TEST(Ply, FilesCutOffAnywhereEndWell) {
  for (const std::string& file : small_files()) {
    EXPECT_TRUE(survives(file));
    int models = 0;
    for (std::size_t size = 0; size < file.size(); ++size) models += survives(file.substr(0, size)) ? 1 : 0;
    EXPECT_LE(models, 3) << file;  // the last spaces and digits of a text
  }
}

TEST(Ply, DamagedFilesEndWell) {
  std::mt19937 random(11);
  int models = 0, errors = 0;
  for (const std::string& file : small_files()) {
    for (int round = 0; round < 1000; ++round) {
      std::string damaged = file;
      for (int i = 0; i < 1 + round % 3; ++i) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0:
            damaged[at] = char(random());
            break;
          case 1:
            damaged.erase(at, 1 + random() % 8);
            break;
          case 2:
            damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 16));
            break;
          default:
            damaged[at] = char(damaged[at] ^ char(1u << (random() % 8)));
        }
      }
      ++(survives(damaged) ? models : errors);
    }
  }
  EXPECT_GT(models, 100);
  EXPECT_GT(errors, 100);
}

TEST(Ply, GarbageBehindAHeaderEndsWell) {
  std::mt19937 random(5);
  static constexpr std::string_view kTypes[] = {"char", "uchar", "short", "ushort",
                                                "int",  "uint",  "float", "double"};
  static constexpr std::string_view kNames[] = {"x", "y", "z", "nx", "red", "u", "vertex_indices", "vertex1"};
  static constexpr std::string_view kElements[] = {"vertex", "face", "edge", "tristrips", "other"};
  const auto pick = [&](const auto& from) { return from[random() % std::size(from)]; };
  for (int round = 0; round < 3000; ++round) {
    PlyWriter out(kForms[random() % 3]);
    for (std::size_t e = 0; e < 1 + random() % 4; ++e) {
      out.line(fmt::format("element {} {}", e == 0 ? "vertex" : pick(kElements), random() % 9));
      for (std::size_t p = 0; e == 0 && p < 3; ++p)
        out.line(fmt::format("property {} {}", pick(kTypes), kNames[p]));
      for (std::size_t p = 0; p < random() % 4; ++p)
        out.line(random() % 2 == 0
                     ? fmt::format("property {} {}", pick(kTypes), pick(kNames))
                     : fmt::format("property list {} {} {}", pick(kTypes), pick(kTypes), pick(kNames)));
    }
    std::string file = out.line("end_header").file();
    const bool text = random() % 2 == 0;
    for (std::size_t i = 0; i < random() % 400; ++i)
      file += text ? "0123456789 -.\n"[random() % 14] : char(random() % 4 == 0 ? random() : random() % 4);
    survives(file);
  }
}

}  // namespace
}  // namespace furnace
