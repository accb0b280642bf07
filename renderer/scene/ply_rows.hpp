// One row of an element of a PLY file, by what its properties mean.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "renderer/scene/ply_body.hpp"
#include "renderer/scene/ply_header.hpp"

namespace furnace {

// What is kept of a row: numbers first, then lists.
enum class PlyRole : std::uint8_t {
  kX,
  kY,
  kZ,
  kNormalX,
  kNormalY,
  kNormalZ,
  kRed,
  kGreen,
  kBlue,
  kAlpha,
  kU,
  kV,
  kTexture,
  kFirst,
  kSecond,
  kCorners,
  kCornerUvs,
  kNone
};
inline constexpr std::size_t kPlyNumbers = std::size_t(PlyRole::kCorners);

// Beyond its range infinite.
float float_of(double value);

// The rows of a vertex, face, tristrips or edge, known by the element's name; what has no role is skipped. Colours are
// [0,1] where the file keeps to its type's range. Errors: those of PlyBody. Threads: one. Owns: the row read last.
class PlyRows {
 public:
  PlyRows(const PlyElement& element, PlyBody& body);

  bool has(PlyRole role) const { return (roles_ >> unsigned(role) & 1u) != 0; }
  bool has_color() const { return has(PlyRole::kRed) && has(PlyRole::kGreen) && has(PlyRole::kBlue); }

  void read(std::uint64_t row);

  double number(PlyRole role) const { return values_[std::size_t(role)]; }
  float real(PlyRole role) const { return float_of(number(role)); }
  glm::vec4 color() const;
  const std::vector<double>& corners() const { return corners_; }
  const std::vector<double>& corner_uvs() const { return corner_uvs_; }

 private:
  // Read as value * scale + offset.
  struct Column {
    PlyProperty property;
    PlyRole role = PlyRole::kNone;
    double scale = 1, offset = 0;
  };
  static Column column_of(const PlyProperty& property, PlyRole role);
  void read_list(const Column& column);

  const PlyElement& element_;
  PlyBody& body_;
  std::vector<Column> columns_;
  std::uint32_t roles_ = 0;  // those that columns have, as bits
  std::array<double, kPlyNumbers> values_{};
  std::vector<double> corners_, corner_uvs_;
};

}  // namespace furnace
