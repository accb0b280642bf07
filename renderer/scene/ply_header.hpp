// The header of a PLY file (Turk 1994, "The PLY Polygon File Format"): which elements follow, and of which properties.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace furnace {

enum class PlyEncoding : std::uint8_t { kText, kLittleEndian, kBigEndian };
enum class PlyType : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
std::size_t ply_type_bytes(PlyType type);

struct PlyProperty {
  std::string_view name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type;  // a list
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

// Names are views of the file.
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;
  std::vector<std::string_view> textures;  // MeshLab's `comment TextureFile NAME`, in order
  std::size_t body = 0;                    // where it begins, bytes
  std::size_t body_line = 1;               // of its first line
};

// "is not a readable PLY file: " and why: kUnprocessable.
[[noreturn]] void fail_ply(std::string_view why);
// A name as errors quote it: its beginning, if it is long.
std::string_view ply_name(std::string_view name);

// Lines end with \n or \r\n, or with \r if the first does. Every element has a place in the rest of the file, as far as its
// least size tells: what is sized by a count is no larger than the file allows.
// Errors: kUnprocessable, naming the line. Threads: any.
PlyHeader read_ply_header(std::string_view file);

}  // namespace furnace
