#include "renderer/scene/ply_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

namespace furnace {
namespace {

struct NamedRole {
  std::string_view name;
  PlyRole role;
};

// Turk's names, and those of Blender, CloudCompare, MeshLab, the Point Cloud Library, and splats.
constexpr std::array kVertexNames = std::to_array<NamedRole>({{"x", PlyRole::kX},
                                                              {"y", PlyRole::kY},
                                                              {"z", PlyRole::kZ},
                                                              {"nx", PlyRole::kNormalX},
                                                              {"ny", PlyRole::kNormalY},
                                                              {"nz", PlyRole::kNormalZ},
                                                              {"normal_x", PlyRole::kNormalX},
                                                              {"normal_y", PlyRole::kNormalY},
                                                              {"normal_z", PlyRole::kNormalZ},
                                                              {"red", PlyRole::kRed},
                                                              {"green", PlyRole::kGreen},
                                                              {"blue", PlyRole::kBlue},
                                                              {"alpha", PlyRole::kAlpha},
                                                              {"diffuse_red", PlyRole::kRed},
                                                              {"diffuse_green", PlyRole::kGreen},
                                                              {"diffuse_blue", PlyRole::kBlue},
                                                              {"diffuse_alpha", PlyRole::kAlpha},
                                                              {"r", PlyRole::kRed},
                                                              {"g", PlyRole::kGreen},
                                                              {"b", PlyRole::kBlue},
                                                              {"a", PlyRole::kAlpha},
                                                              {"f_dc_0", PlyRole::kRed},
                                                              {"f_dc_1", PlyRole::kGreen},
                                                              {"f_dc_2", PlyRole::kBlue},
                                                              {"u", PlyRole::kU},
                                                              {"v", PlyRole::kV},
                                                              {"s", PlyRole::kU},
                                                              {"t", PlyRole::kV},
                                                              {"tx", PlyRole::kU},
                                                              {"ty", PlyRole::kV},
                                                              {"texture_u", PlyRole::kU},
                                                              {"texture_v", PlyRole::kV}});
constexpr std::array kFaceNames = std::to_array<NamedRole>({{"red", PlyRole::kRed},
                                                            {"green", PlyRole::kGreen},
                                                            {"blue", PlyRole::kBlue},
                                                            {"alpha", PlyRole::kAlpha},
                                                            {"texnumber", PlyRole::kTexture}});
constexpr std::array kLists = std::to_array<NamedRole>({{"vertex_indices", PlyRole::kCorners},
                                                        {"vertex_index", PlyRole::kCorners},
                                                        {"texcoord", PlyRole::kCornerUvs}});
constexpr std::array kEdgeNames =
    std::to_array<NamedRole>({{"vertex1", PlyRole::kFirst}, {"vertex2", PlyRole::kSecond}});

PlyRole role_of(std::string_view name, std::span<const NamedRole> names) {
  const auto row = std::ranges::find(names, name, &NamedRole::name);
  return row == names.end() ? PlyRole::kNone : row->role;
}

PlyRole role_of(const PlyElement& element, const PlyProperty& property) {
  if (property.count_type) return element.name == "vertex" ? PlyRole::kNone : role_of(property.name, kLists);
  if (element.name == "vertex") return role_of(property.name, kVertexNames);
  if (element.name == "face") return role_of(property.name, kFaceNames);
  return element.name == "edge" ? role_of(property.name, kEdgeNames) : PlyRole::kNone;
}

}  // namespace

float float_of(double value) {
  using Limits = std::numeric_limits<float>;
  if (std::abs(value) > double(Limits::max())) return value > 0 ? Limits::infinity() : -Limits::infinity();
  return float(value);
}

PlyRows::PlyRows(const PlyElement& element, PlyBody& body) : element_(element), body_(body) {
  for (const PlyProperty& property : element.properties) {
    PlyRole role = role_of(element, property);
    if (has(role)) role = PlyRole::kNone;  // of two with the same meaning the first counts
    if (role != PlyRole::kNone) roles_ |= 1u << unsigned(role);
    columns_.push_back(column_of(property, role));
  }
  values_[std::size_t(PlyRole::kAlpha)] = 1;
}

// Colours of integers: 255 is 1, whatever the type, but for those that can say no more than 127, or have twice the bits.
PlyRows::Column PlyRows::column_of(const PlyProperty& property, PlyRole role) {
  constexpr double kConstantHarmonic = 0.28209479177387814;  // 1 / (2 sqrt(pi))
  Column column{property, role};
  if (role < PlyRole::kRed || role > PlyRole::kAlpha) return column;
  if (property.name.starts_with("f_dc_")) {
    column.scale = kConstantHarmonic;
    column.offset = 0.5;
  } else if (property.type < PlyType::kFloat32) {
    const int most = property.type == PlyType::kInt8 ? 127 : property.type == PlyType::kUint16 ? 65535 : 255;
    column.scale = 1.0 / most;
  }
  return column;
}

void PlyRows::read(std::uint64_t row) {
  body_.begin_row(element_, row);
  for (const Column& column : columns_) {
    if (column.role == PlyRole::kNone) {
      body_.skip(column.property);
    } else if (column.property.count_type) {
      read_list(column);
    } else {
      values_[std::size_t(column.role)] = body_.number(column.property.type) * column.scale + column.offset;
    }
  }
}

void PlyRows::read_list(const Column& column) {
  std::vector<double>& list = column.role == PlyRole::kCorners ? corners_ : corner_uvs_;
  list.resize(body_.list_size(*column.property.count_type, column.property.type));
  for (double& value : list) value = body_.number(column.property.type);
}

glm::vec4 PlyRows::color() const {
  return {real(PlyRole::kRed), real(PlyRole::kGreen), real(PlyRole::kBlue), real(PlyRole::kAlpha)};
}

}  // namespace furnace
