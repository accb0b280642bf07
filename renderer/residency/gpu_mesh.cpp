#include "renderer/residency/gpu_mesh.hpp"

#include <bit>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/scene/mesh_patches.hpp"

namespace furnace {
namespace {

using Row = glm::vec4;

GLenum primitive_mode(Topology topology) {
  switch (topology) {
    case Topology::kPoints:
      return GL_POINTS;
    case Topology::kLines:
      return GL_LINES;
    case Topology::kTriangles:
      return GL_TRIANGLES;
  }
  return GL_TRIANGLES;
}

template <class T>
T value_at(const std::vector<T>& values, std::size_t i) {
  return values.empty() ? T(0) : values[i];
}

// The number of a vertex's patch rides in the last component of its position's row, as bits.
std::vector<Row> interleave(const Mesh& mesh, std::uint32_t rows) {
  const std::vector<std::uint32_t> patches = mesh_patches(mesh);
  std::vector<Row> vertices;
  vertices.reserve(mesh.positions.size() * rows);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    vertices.emplace_back(mesh.positions[i], std::bit_cast<float>(patches[i]));
    vertices.emplace_back(value_at(mesh.normals, i), 0);
    vertices.push_back(value_at(mesh.tangents, i));
    vertices.emplace_back(value_at(mesh.uvs[0], i), value_at(mesh.uvs[1], i));
    if (!mesh.colors.empty()) vertices.push_back(mesh.colors[i]);
  }
  return vertices;
}

// Locations of forward.vert and visibility.vert.
void describe_attributes(const GpuMesh& mesh) {
  constexpr GLuint kPosition = 0, kNormal = 1, kTangent = 2, kUvs = 3, kColor = 5, kPatch = 6;
  const GLuint vao = mesh.vertex_array.id();
  glVertexArrayVertexBuffer(vao, 0, mesh.vertices.id(), 0, GLsizei(mesh.vertex_rows * sizeof(Row)));
  const auto row = [&](GLuint location, GLint components, GLuint index) {
    glEnableVertexArrayAttrib(vao, location);
    glVertexArrayAttribFormat(vao, location, components, GL_FLOAT, GL_FALSE, GLuint(index * sizeof(Row)));
    glVertexArrayAttribBinding(vao, location, 0);
  };
  row(kPosition, 3, 0);
  row(kNormal, 3, 1);
  row(kTangent, 4, 2);
  row(kUvs, 4, 3);
  if (mesh.vertex_rows > 4) row(kColor, 4, 4);
  glEnableVertexArrayAttrib(vao, kPatch);
  glVertexArrayAttribIFormat(vao, kPatch, 1, GL_UNSIGNED_INT, 3 * sizeof(float));
  glVertexArrayAttribBinding(vao, kPatch, 0);
  glVertexArrayElementBuffer(vao, mesh.indices.id());
}

}  // namespace

GpuMesh upload_mesh(gl::Context& context, const Mesh& mesh) {
  GpuMesh gpu;
  gpu.vertex_rows = mesh.colors.empty() ? 4 : 5;
  const std::size_t rows = mesh.positions.size() * gpu.vertex_rows;
  const std::size_t limit = context.limits().max_buffer_texels;
  if (std::max(rows, mesh.indices.size()) > limit) {
    fail(ErrorCode::kTooLarge,
         fmt::format(
             "mesh \"{}\" has {} vertices and {} indices, more than this GPU can read at once; divide it",
             mesh.name, mesh.positions.size(), mesh.indices.size()));
  }
  constexpr std::size_t kMostTriangles = 1u << 24;  // shaders/lib/visibility.glsl
  if (mesh.topology == Topology::kTriangles && mesh.indices.size() / 3 > kMostTriangles) {
    fail(ErrorCode::kTooLarge, fmt::format("mesh \"{}\" has {} triangles, more than {}; divide it", mesh.name,
                                           mesh.indices.size() / 3, kMostTriangles));
  }
  const std::vector<Row> vertices = interleave(mesh, gpu.vertex_rows);
  gpu.vertices = gl::create_buffer(context, vertices.data(), rows * sizeof(Row));
  gpu.indices = gl::create_buffer(context, mesh.indices.data(), mesh.indices.size() * sizeof(std::uint32_t));
  gpu.vertex_texels = gl::create_buffer_texture(context, GL_RGBA32F, gpu.vertices);
  gpu.index_texels = gl::create_buffer_texture(context, GL_R32UI, gpu.indices);
  gpu.vertex_array = gl::create_vertex_array(context);
  describe_attributes(gpu);
  gpu.mode = primitive_mode(mesh.topology);
  gpu.index_count = GLsizei(mesh.indices.size());
  gpu.bounds = mesh.bounds;
  gpu.bytes = rows * sizeof(Row) + mesh.indices.size() * sizeof(std::uint32_t);
  return gpu;
}

}  // namespace furnace
