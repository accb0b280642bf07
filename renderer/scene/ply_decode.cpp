#include "renderer/scene/ply_decode.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "renderer/scene/ply_body.hpp"
#include "renderer/scene/ply_header.hpp"
#include "renderer/scene/ply_rows.hpp"
#include "renderer/scene/polygon.hpp"

namespace furnace {
namespace {

// Corners of one topology and texture. `uvs` and `colors`: of each corner, or empty.
struct Corners {
  std::vector<std::uint32_t> indices;
  std::vector<glm::vec2> uvs;
  std::vector<glm::vec4> colors;
};

// Threads: one. Owns: all that was read.
class PlyReader {
 public:
  PlyReader(std::string_view file, ModelBuilder& builder, const Deadline& deadline)
      : header_(read_ply_header(file)),
        body_(file, header_, deadline),
        builder_(builder),
        limits_(builder.limits()) {}

  void read();

 private:
  const PlyElement* find_vertices() const;
  void read_vertices(const PlyElement& element);
  void read_drawn(const PlyElement& element);
  void read_faces(const PlyElement& element);
  void add_face(const PlyRows& row, bool colored);
  void read_strips(const PlyElement& element);
  void read_edges(const PlyElement& element);
  std::uint32_t vertex_of(double index) const;
  void add_elements(std::uint64_t count);
  void add_triangle(Corners& to, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void add_materials();
  void add_part(const Corners& corners, Topology topology, std::uint32_t material);

  PlyHeader header_;
  PlyBody body_;
  ModelBuilder& builder_;
  const PlainModelLimits& limits_;
  PolygonCutter cutter_;
  Mesh vertices_;  // without indices
  std::uint64_t vertex_count_ = 0, elements_ = 0;
  std::vector<Corners> triangles_;  // by texture
  Corners lines_, points_;
  // Of the face that is read.
  std::vector<std::uint32_t> polygon_, cut_;
  std::vector<glm::vec3> polygon_positions_;
};

void PlyReader::read() {
  const PlyElement* vertices = find_vertices();
  vertex_count_ = vertices->count;
  triangles_.resize(std::max<std::size_t>(header_.textures.size(), 1));
  bool drawn = false, has_vertices = false;
  std::vector<std::pair<const PlyElement*, std::size_t>> before;  // those that come before the vertices
  for (const PlyElement& element : header_.elements) {
    if (&element == vertices) {
      read_vertices(element);
      has_vertices = true;
      continue;
    }
    const bool draws = element.name == "face" || element.name == "tristrips" || element.name == "edge";
    drawn = drawn || (draws && element.count > 0);
    if (draws && has_vertices) {
      read_drawn(element);
    } else {
      if (draws) before.emplace_back(&element, body_.place());
      body_.skip(element);
    }
  }
  for (const auto& [element, place] : before) {
    body_.go_to(place);
    read_drawn(*element);
  }
  if (!drawn) {
    add_elements(vertex_count_);
    points_.indices.resize(vertex_count_);
    std::iota(points_.indices.begin(), points_.indices.end(), 0u);
  }
  add_materials();
  for (std::size_t i = 0; i < triangles_.size(); ++i)
    add_part(triangles_[i], Topology::kTriangles, std::uint32_t(i));
  add_part(lines_, Topology::kLines, 0);
  add_part(points_, Topology::kPoints, 0);
}

const PlyElement* PlyReader::find_vertices() const {
  const auto is_vertex = [](const PlyElement& element) { return element.name == "vertex"; };
  const auto count = std::ranges::count_if(header_.elements, is_vertex);
  if (count != 1) fail_ply(fmt::format("it has {} elements \"vertex\", not one", count));
  return &*std::ranges::find_if(header_.elements, is_vertex);
}

void PlyReader::read_vertices(const PlyElement& element) {
  PlyRows rows(element, body_);
  if (!rows.has(PlyRole::kX) || !rows.has(PlyRole::kY) || !rows.has(PlyRole::kZ))
    fail_ply("its vertices need x, y and z");
  const bool has_normals =
      rows.has(PlyRole::kNormalX) && rows.has(PlyRole::kNormalY) && rows.has(PlyRole::kNormalZ);
  const bool has_uvs = rows.has(PlyRole::kU) && rows.has(PlyRole::kV);
  const bool has_colors = rows.has_color();
  if (element.count > std::uint64_t(limits_.max_vertices)) fail_too_many(limits_.max_vertices, "vertices");
  const std::size_t bytes = sizeof(glm::vec3) * (has_normals ? 2 : 1) + (has_uvs ? sizeof(glm::vec2) : 0) +
                            (has_colors ? sizeof(glm::vec4) : 0);
  if (element.count > std::uint64_t(limits_.max_bytes) / bytes)
    fail_too_many(limits_.max_bytes, "bytes of geometry");

  vertices_.positions.reserve(element.count);
  vertices_.normals.reserve(has_normals ? element.count : 0);
  vertices_.uvs[0].reserve(has_uvs ? element.count : 0);
  vertices_.colors.reserve(has_colors ? element.count : 0);
  for (std::uint64_t row = 0; row < element.count; ++row) {
    rows.read(row);
    vertices_.positions.emplace_back(rows.real(PlyRole::kX), rows.real(PlyRole::kY), rows.real(PlyRole::kZ));
    if (has_normals)
      vertices_.normals.emplace_back(rows.real(PlyRole::kNormalX), rows.real(PlyRole::kNormalY),
                                     rows.real(PlyRole::kNormalZ));
    if (has_uvs) vertices_.uvs[0].emplace_back(rows.real(PlyRole::kU), 1 - rows.real(PlyRole::kV));
    if (has_colors) vertices_.colors.push_back(rows.color());
  }
}

void PlyReader::read_drawn(const PlyElement& element) {
  if (element.count > std::uint64_t(limits_.max_elements))
    fail_too_many(limits_.max_elements, "points, lines and triangles");
  if (element.name == "face") return read_faces(element);
  if (element.name == "edge") return read_edges(element);
  read_strips(element);
}

void PlyReader::add_elements(std::uint64_t count) {
  elements_ += count;
  if (elements_ > std::uint64_t(limits_.max_elements))
    fail_too_many(limits_.max_elements, "points, lines and triangles");
}

std::uint32_t PlyReader::vertex_of(double index) const {
  if (!(index >= 0 && index < double(vertex_count_)) || index != std::floor(index))
    body_.fail_row(fmt::format("names vertex {:.9g} of {}", index, vertex_count_));
  return std::uint32_t(index);
}

void PlyReader::add_triangle(Corners& to, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a != b && b != c && c != a) to.indices.insert(to.indices.end(), {a, b, c});
}

void PlyReader::read_faces(const PlyElement& element) {
  if (element.count == 0) return;
  PlyRows rows(element, body_);
  if (!rows.has(PlyRole::kCorners)) fail_ply("its faces need a list vertex_indices");
  const bool colored = rows.has_color() && vertices_.colors.empty();
  for (std::uint64_t row = 0; row < element.count; ++row) {
    rows.read(row);
    add_face(rows, colored);
  }
}

void PlyReader::add_face(const PlyRows& row, bool colored) {
  const std::vector<double>& uvs = row.corner_uvs();
  const std::size_t sides = row.corners().size();
  if (!uvs.empty() && uvs.size() != 2 * sides)
    body_.fail_row(fmt::format("has {} texture coordinates for {} corners", uvs.size(), sides));
  add_elements(sides > 2 ? sides - 2 : 1);
  polygon_.clear();
  for (const double index : row.corners()) polygon_.push_back(vertex_of(index));
  if (sides == 1) points_.indices.push_back(polygon_[0]);
  if (sides == 2 && polygon_[0] != polygon_[1])
    lines_.indices.insert(lines_.indices.end(), polygon_.begin(), polygon_.end());
  if (sides < 3) return;

  const double texture = row.number(PlyRole::kTexture);
  const bool known = texture > 0 && texture < double(triangles_.size());
  Corners& to = triangles_[known ? std::size_t(texture) : 0];
  polygon_positions_.clear();
  for (const std::uint32_t vertex : polygon_) polygon_positions_.push_back(vertices_.positions[vertex]);
  cut_.clear();
  cutter_.cut(polygon_positions_, cut_);
  for (std::size_t i = 0; i + 2 < cut_.size(); i += 3) {
    const std::size_t begin = to.indices.size();
    add_triangle(to, polygon_[cut_[i]], polygon_[cut_[i + 1]], polygon_[cut_[i + 2]]);
    if (to.indices.size() == begin) continue;
    // Faces before it, or after it, may have none: those of the vertices, else (0, 0).
    if (!uvs.empty()) {
      to.uvs.resize(begin, glm::vec2(std::numeric_limits<float>::quiet_NaN()));
      for (std::size_t k = i; k < i + 3; ++k)
        to.uvs.emplace_back(float_of(uvs[2 * cut_[k]]), 1 - float_of(uvs[2 * cut_[k] + 1]));
    }
    if (colored) {
      to.colors.resize(begin, glm::vec4(1));
      to.colors.insert(to.colors.end(), 3, row.color());
    }
  }
}

// Each vertex makes a triangle with the two before it, every other one turned; -1 begins anew.
void PlyReader::read_strips(const PlyElement& element) {
  if (element.count == 0) return;
  PlyRows rows(element, body_);
  if (!rows.has(PlyRole::kCorners)) fail_ply("its strips need a list vertex_indices");
  for (std::uint64_t row = 0; row < element.count; ++row) {
    rows.read(row);
    const std::size_t vertices = rows.corners().size();
    add_elements(vertices > 2 ? vertices - 2 : 0);
    std::uint32_t before[2] = {0, 0};
    std::size_t length = 0;
    for (const double index : rows.corners()) {
      if (index == -1) {
        length = 0;
        continue;
      }
      const std::uint32_t vertex = vertex_of(index);
      if (length >= 2) add_triangle(triangles_[0], before[length % 2], before[1 - length % 2], vertex);
      before[0] = before[1];
      before[1] = vertex;
      ++length;
    }
  }
}

void PlyReader::read_edges(const PlyElement& element) {
  if (element.count == 0) return;
  PlyRows rows(element, body_);
  if (!rows.has(PlyRole::kFirst) || !rows.has(PlyRole::kSecond))
    fail_ply("its edges need vertex1 and vertex2");
  for (std::uint64_t row = 0; row < element.count; ++row) {
    rows.read(row);
    add_elements(1);
    const std::uint32_t first = vertex_of(rows.number(PlyRole::kFirst)),
                        second = vertex_of(rows.number(PlyRole::kSecond));
    if (first != second) lines_.indices.insert(lines_.indices.end(), {first, second});
  }
}

void PlyReader::add_materials() {
  if (std::int64_t(triangles_.size()) > limits_.max_materials)
    fail_too_many(limits_.max_materials, "textures");
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    PlainMaterial material = builder_.plain_material();
    if (i < header_.textures.size())
      material.textures[std::size_t(PlainTexture::kBaseColor)] = builder_.add_text(header_.textures[i]);
    builder_.add_material(material);
  }
}

void PlyReader::add_part(const Corners& corners, Topology topology, std::uint32_t material) {
  Mesh mesh;
  mesh.topology = topology;
  mesh.indices = corners.indices;
  for (const std::uint32_t vertex : mesh.indices) {
    const glm::vec3& p = vertices_.positions[vertex];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      fail_ply(fmt::format("vertex {} has a position that is not finite", vertex));
  }
  // Where corners have nothing of their own and are as many as the vertices, these do as they are.
  const bool shared =
      corners.uvs.empty() && corners.colors.empty() && mesh.indices.size() >= vertices_.positions.size();
  const auto each = [&](const auto& values) {
    if (values.empty() || shared) return values;
    std::decay_t<decltype(values)> out;
    out.reserve(mesh.indices.size());
    for (const std::uint32_t vertex : mesh.indices) out.push_back(values[vertex]);
    return out;
  };
  mesh.positions = each(vertices_.positions);
  mesh.normals = each(vertices_.normals);
  mesh.uvs[0] = each(vertices_.uvs[0]);
  mesh.colors = corners.colors.empty() ? each(vertices_.colors) : corners.colors;
  if (!corners.uvs.empty()) {
    mesh.uvs[0].resize(mesh.indices.size(), glm::vec2(0));
    for (std::size_t i = 0; i < corners.uvs.size(); ++i)
      if (!std::isnan(corners.uvs[i].x)) mesh.uvs[0][i] = corners.uvs[i];
  }
  if (!corners.colors.empty()) mesh.colors.resize(mesh.indices.size(), glm::vec4(1));
  if (!shared) std::iota(mesh.indices.begin(), mesh.indices.end(), 0u);
  builder_.add_part(std::move(mesh), material, false);
}

}  // namespace

void add_ply(std::span<const std::byte> document, ModelBuilder& builder, const Deadline& deadline) {
  PlyReader({reinterpret_cast<const char*>(document.data()), document.size()}, builder, deadline).read();
}

}  // namespace furnace
