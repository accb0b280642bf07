#include "renderer/scene/model_builder.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/model_surface.hpp"

namespace furnace {
namespace {

std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 200;
  std::string out(text.substr(0, kLongest));
  for (char& c : out)
    if (c < ' ' || c > '~') c = '?';
  return out;
}

bool is_direction(const glm::vec3& v) {
  constexpr float kLeast = 1e-6f;
  const float length = glm::length(v);
  return std::isfinite(length) && length > kLeast;
}

void drop_what_is_broken(Mesh& mesh) {
  const auto has_direction = [&](std::uint32_t index) { return is_direction(mesh.normals[index]); };
  if (!mesh.normals.empty() && !std::ranges::all_of(mesh.indices, has_direction)) mesh.normals.clear();
  for (glm::vec3& normal : mesh.normals) normal = glm::vec3(glm::normalize(glm::dvec3(normal)));
  for (glm::vec2& uv : mesh.uvs[0])
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = {0, 0};
  for (glm::vec4& color : mesh.colors)
    for (int i = 0; i < 4; ++i) color[i] = color[i] > 0 ? std::min(color[i], 1.0f) : 0.0f;
  for (const std::uint32_t index : mesh.indices) {
    const glm::vec3& p = mesh.positions[index];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      fail(ErrorCode::kUnprocessable, "has a position that is not finite");
  }
}

}  // namespace

void fail_too_many(std::int64_t most, std::string_view what) {
  fail(ErrorCode::kTooLarge, fmt::format("the model has more than {} {}", most, what));
}

void fail_unreadable(ModelFormat format, std::string_view why) {
  fail(ErrorCode::kUnprocessable,
       fmt::format("is not a readable {} file: {}", model_format_name(format), printable(why)));
}

TextRange ModelBuilder::add_text(std::string_view text) {
  const TextRange range{std::uint32_t(model_.text.size()), std::uint32_t(text.size())};
  model_.text.insert(model_.text.end(), text.begin(), text.end());
  return range;
}

PlainMaterial ModelBuilder::plain_material() {
  PlainMaterial material;
  material.name = add_text("default");
  material.metallic = 0;
  material.perceptual_roughness = 0.5f;
  return material;
}

template <class Value>
void ModelBuilder::append(std::vector<Value>& to, const std::vector<Value>& values, std::size_t first) {
  if (values.empty() && to.empty()) return;
  to.resize(first);  // parts before it without the attribute
  to.insert(to.end(), values.begin(), values.end());
  to.resize(model_.positions.size());
}

void ModelBuilder::add_part(Mesh mesh, std::uint32_t material, bool flat) {
  if (mesh.indices.empty()) return;
  if (std::int64_t(model_.parts.size()) >= limits_.max_materials)
    fail_too_many(limits_.max_materials, "parts");
  const auto corners = std::size_t(mesh.topology) + 1;
  elements_ += std::int64_t(mesh.indices.size() / corners);
  if (elements_ > limits_.max_elements) fail_too_many(limits_.max_elements, "points, lines and triangles");
  drop_what_is_broken(mesh);
  if (flat) mesh.normals.clear();
  const bool makes_normals = mesh.topology == Topology::kTriangles && !flat && mesh.normals.empty();
  if (makes_normals) {
    generate_smooth_normals(mesh);
  } else {
    weld_vertices(mesh);
  }

  const std::size_t first = model_.positions.size();
  if (std::int64_t(first + mesh.positions.size()) > limits_.max_vertices)
    fail_too_many(limits_.max_vertices, "vertices");
  constexpr std::int64_t kVertexBytes = 2 * sizeof(glm::vec3) + sizeof(glm::vec2) + sizeof(glm::vec4);
  const auto indices = std::int64_t(model_.indices.size() + mesh.indices.size());
  if (std::int64_t(first + mesh.positions.size()) * kVertexBytes + indices * 4 > limits_.max_bytes)
    fail_too_many(limits_.max_bytes, "bytes of geometry");
  PlainPart part;
  part.name = add_text(mesh.name);
  part.topology = std::uint32_t(mesh.topology);
  part.material = material;
  part.has_normals = mesh.normals.empty() ? 0 : 1;
  part.has_uvs = mesh.uvs[0].empty() ? 0 : 1;
  part.has_colors = mesh.colors.empty() ? 0 : 1;
  part.vertices = std::uint32_t(mesh.positions.size());
  part.indices = std::uint32_t(mesh.indices.size());
  part.made_normals = makes_normals ? 1 : 0;
  model_.parts.push_back(part);
  model_.positions.insert(model_.positions.end(), mesh.positions.begin(), mesh.positions.end());
  append(model_.normals, mesh.normals, first);
  append(model_.uvs, mesh.uvs[0], first);
  append(model_.colors, mesh.colors, first);
  model_.indices.insert(model_.indices.end(), mesh.indices.begin(), mesh.indices.end());
}

PlainModel ModelBuilder::take() {
  if (model_.parts.empty())
    fail(ErrorCode::kUnprocessable, "the model has nothing to draw: no points, lines or triangles");
  return std::move(model_);
}

}  // namespace furnace
