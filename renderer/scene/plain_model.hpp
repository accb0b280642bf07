// What the reader of OBJ, STL and PLY makes of a file: flat arrays without pointers, so that they may come from a process
// that is not trusted.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/base/deadline.hpp"
#include "renderer/scene/model_format.hpp"

namespace furnace {

struct PlainModelLimits {
  std::int64_t max_vertices = 30'000'000;
  std::int64_t max_elements = 20'000'000;  // points, lines and triangles
  std::int64_t max_bytes = 2ll << 30;      // of all arrays
  std::int64_t max_materials = 10'000;     // and as many parts
};

struct TextRange {
  std::uint32_t first = 0, size = 0;  // of PlainModel::text, bytes
};

enum class PlainTexture { kBaseColor, kEmissive, kNormal, kBump, kAlpha };
inline constexpr std::size_t kPlainTextures = 5;

// Numbers as the file has them: what they mean to a renderer is model_import's.
struct PlainMaterial {
  TextRange name;
  glm::vec3 diffuse{0.6f};          // Kd, [0,1]
  glm::vec3 emission{0};            // Ke, >= 0
  float opacity = 1;                // d, [0,1]
  float exponent = 0;               // Ns, >= 0
  float metallic = -1;              // Pm, [0,1]; below 0: not stated
  float perceptual_roughness = -1;  // Pr, [0,1]; below 0: not stated
  float clearcoat = 0;              // Pc, [0,1]
  float clearcoat_perceptual_roughness = 0;
  std::array<TextRange, kPlainTextures> textures;  // names as written, empty: none
};

// A run of vertices and of the indices into them (from 0 at first_vertex), of one topology and material.
struct PlainPart {
  TextRange name;
  std::uint32_t topology = 0;  // furnace::Topology as number
  std::uint32_t material = 0;
  std::uint32_t has_normals = 0, has_uvs = 0, has_colors = 0;  // 0 or 1
  std::uint32_t vertices = 0, indices = 0;                     // parts lie one behind the other
  std::uint32_t made_normals = 0;  // 1: the file has none, or some without direction
};

// The arrays of attributes are empty or as long as `positions`.
struct PlainModel {
  std::vector<char> text;
  std::vector<PlainMaterial> materials;
  std::vector<PlainPart> parts;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // unit
  std::vector<glm::vec2> uvs;      // v as glTF has it, downwards
  std::vector<glm::vec4> colors;   // as the file has them, [0,1]
  std::vector<std::uint32_t> indices;

  std::string_view text_of(const TextRange& range) const {
    return std::string_view(text.data(), text.size()).substr(range.first, range.size);
  }
};

// Reads a file of another format than glTF. `materials` is the text of its MTL files, one behind the other. Polygons
// become triangles, vertices are welded; triangles without normals get smooth ones, but for STL, which stays flat.
// The deadline is looked at while a PLY is read; the other formats know none.
// Errors: kUnprocessable for what cannot be read or draws nothing; kTooLarge for a limit; kDeadlineExceeded. Threads: any.
PlainModel decode_model(std::span<const std::byte> document, std::string_view materials, ModelFormat format,
                        const PlainModelLimits& limits, const Deadline& deadline = {});

// Whether every range, index and number is as said above. A model that is not was made by nobody who read a file.
bool is_sound(const PlainModel& model, const PlainModelLimits& limits);

}  // namespace furnace
