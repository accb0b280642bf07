// Small files of the formats that are no glTF, made here byte by byte.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

namespace furnace::test {

template <class Number>
void put(std::string& to, Number value, bool big_endian = false) {
  auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  to.append(bytes.data(), bytes.size());
}

// Three facets: x = 0, 1, 2 of the corner that is not shared; each with its word of colour.
inline std::string binary_stl(std::string head, const std::array<std::uint16_t, 3>& words) {
  head.resize(80, ' ');
  put(head, std::uint32_t{3});
  for (std::size_t i = 0; i < 3; ++i) {
    // The normal is wrong on purpose.
    for (const float value : {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, float(i + 1), 0.0f, 0.0f, 0.0f, 1.0f, 0.0f})
      put(head, value);
    put(head, words[i]);
  }
  return head;
}

inline std::string text_stl() {
  return "solid a thing\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 2 0 0\n   vertex 0 0 "
         "3\n"
         "  endloop\n endfacet\nendsolid a thing\n";
}

enum class PlyForm { kText, kLittle, kBig };

// A square of the z = 0 plane, its corners coloured, one of them half transparent, as one polygon.
inline std::string ply_square(PlyForm form) {
  static constexpr std::array<std::string_view, 3> kForms = {"ascii", "binary_little_endian",
                                                             "binary_big_endian"};
  std::string file =
      "ply\nformat " + std::string(kForms[std::size_t(form)]) +
      " 1.0\ncomment made for a test\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property uchar alpha\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const int corners[4][2] = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  for (int i = 0; i < 4; ++i) {
    const int alpha = i == 3 ? 128 : 255;
    if (form == PlyForm::kText) {
      file += std::to_string(corners[i][0]) + " " + std::to_string(corners[i][1]) + " 0 188 0 255 " +
              std::to_string(alpha) + "\n";
      continue;
    }
    for (const float value : {float(corners[i][0]), float(corners[i][1]), 0.0f})
      put(file, value, form == PlyForm::kBig);
    for (const int value : {188, 0, 255, alpha}) file += char(value);
  }
  if (form == PlyForm::kText) return file + "4 0 1 2 3\n";
  file += char(4);
  for (std::int32_t i = 0; i < 4; ++i) put(file, i, form == PlyForm::kBig);
  return file;
}

inline std::string ply_cloud() {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
         "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n";
}

// Half a cube: three squares, without normals; the first of a material with everything.
inline std::string obj_corner() {
  return "# a corner\nmtllib corner.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\n"
         "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
         "o back\nusemtl full\nf 1/1 2/2 3/3 4/4\no rest\nusemtl metal\nf 1 5 6 2\nf -7 -4 -1 -3\n";
}

inline std::string mtl_corner() {
  return "newmtl full\nKd 0.5 0.25 1\nKe 2 0.5 0\nNs 98\nd 0.5\nmap_Kd -s 2 2 1 my paint.png\n"
         "map_Bump -bm 0.5 bump.png\nmap_Ks shine.png\n"
         "newmtl metal\nKd 0.5 0.5 0.5\nPm 1\nPr 0.25\n";
}

}  // namespace furnace::test
