// MTL files as text: made readable for the library that parses them, with what it does not tell of textures.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/gltf_notes.hpp"

namespace furnace {

// More of them than any model may have; what comes after is not remembered.
inline constexpr std::size_t kMostMtlMaterials = 20'000, kMostMtlTextures = 100'000;

struct MtlTexture {
  std::string statement;  // as written, "map_Kd"; its capitals mean nothing
  std::string name;       // of the file, as written
  // Of coordinates whose v points upwards: coordinate * scale + offset.
  glm::vec2 scale{1}, offset{0};
  bool clamps = false;
};

struct MtlText {
  // Statements of numbers have as many as they must; a lone one of a colour is all three. Options are left out.
  std::string text;
  // By name as written, "" before the first; textures in the file's order.
  std::map<std::string, std::vector<MtlTexture>> materials;
};

// Numbers that cannot be read, and options of textures that have no counterpart, become notes. Never fails.
MtlText read_mtl(std::string_view mtl, GltfNotes& notes);

// The materials that an OBJ names, each once, at most kMostMtlMaterials.
std::vector<std::string> named_materials(std::string_view obj);

// Whether the OBJ has free-form curves or surfaces.
bool has_free_forms(std::string_view obj);

// "/materials/NAME/STATEMENT", the place of a note.
std::string mtl_place(std::string_view material, std::string_view statement);

}  // namespace furnace
