// Which format a model's file has, and which other files it names. Pure functions of untrusted bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace furnace {

enum class ModelFormat : std::uint8_t { kGltf, kObj, kStl, kPly };
std::string_view model_format_name(ModelFormat format);  // "glTF", "OBJ", "STL", "PLY"

enum class UpAxis : std::uint8_t { kY, kZ };

// By content; where that does not tell, by the ending of `name`; else glTF, whose reader says what is wrong.
ModelFormat model_format(std::span<const std::byte> document, std::string_view name);
// What a file is that none of these formats is, as far as its first bytes tell: "an FBX file"; "": not known.
std::string_view foreign_format(std::string_view document);
// Whether a file with this ending is a model at all.
bool is_model_name(std::string_view name);

// Facets of a binary STL whose size is right for them.
inline constexpr std::size_t kStlHeadBytes = 84, kStlFacetBytes = 50;
std::optional<std::uint32_t> binary_stl_facets(std::span<const std::byte> document);
// Begins with "solid" and has what a text needs; some binary ones do, too.
bool is_text_stl(std::string_view document);

// Without the byte order mark of UTF-8, where there is one.
std::string_view without_mark(std::string_view text);

// The text as UTF-8 without control characters: each byte that is neither becomes "?".
std::string readable_text(std::string_view text);

// A file's name as OBJ, MTL and PLY write it, as a path beside the model: separators become "/", and of a path that is
// absolute or climbs only the last segment counts, as such paths are of the machine that wrote them. None: names no file.
std::optional<std::string> sibling_name(std::string_view written);

// Normalised names, each once, at most kMostSiblings; in the file's order, textures by the names of their materials.
inline constexpr std::size_t kMostSiblings = 1000;
std::vector<std::string> material_libraries(std::string_view obj);
std::vector<std::string> texture_names(std::string_view mtl);
std::vector<std::string> ply_texture_names(std::string_view ply);

}  // namespace furnace
