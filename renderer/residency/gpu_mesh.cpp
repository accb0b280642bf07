#include "renderer/residency/gpu_mesh.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "renderer/base/error.hpp"

namespace furnace {
namespace {

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

// Locations of forward.vert and visibility.vert.
void describe_attributes(const GpuMesh& mesh) {
  constexpr GLuint kPosition = 0, kNormal = 1, kTangent = 2, kUvs = 3, kColor = 5, kPatch = 6;
  const GLuint vao = mesh.vertex_array.id();
  glVertexArrayVertexBuffer(vao, 0, mesh.vertices.id(), 0, GLsizei(mesh.vertex_rows * sizeof(glm::vec4)));
  const auto row = [&](GLuint location, GLint components, GLuint index) {
    glEnableVertexArrayAttrib(vao, location);
    glVertexArrayAttribFormat(vao, location, components, GL_FLOAT, GL_FALSE,
                              GLuint(index * sizeof(glm::vec4)));
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

GpuMesh upload_mesh(gl::Context& context, const Mesh& mesh, const PackedMesh& packed) {
  const std::size_t limit = context.limits().max_buffer_texels;
  if (std::max(packed.rows.size(), mesh.indices.size()) > limit) {
    fail(ErrorCode::kTooLarge,
         fmt::format(
             "mesh \"{}\" has {} vertices and {} indices, more than this GPU can read at once; divide it",
             mesh.name, mesh.positions.size(), mesh.indices.size()));
  }
  const std::size_t vertex_bytes = packed.rows.size() * sizeof(glm::vec4),
                    index_bytes = mesh.indices.size() * sizeof(std::uint32_t);
  GpuMesh gpu;
  gpu.vertex_rows = packed.rows_per_vertex;
  gpu.vertices = gl::create_buffer(context, packed.rows.data(), vertex_bytes);
  gpu.indices = gl::create_buffer(context, mesh.indices.data(), index_bytes);
  gpu.vertex_texels = gl::create_buffer_texture(context, GL_RGBA32F, gpu.vertices);
  gpu.index_texels = gl::create_buffer_texture(context, GL_R32UI, gpu.indices);
  gpu.vertex_array = gl::create_vertex_array(context);
  describe_attributes(gpu);
  gpu.mode = primitive_mode(mesh.topology);
  gpu.index_count = GLsizei(mesh.indices.size());
  gpu.bounds = mesh.bounds;
  gpu.bytes = vertex_bytes + index_bytes;
  return gpu;
}

}  // namespace furnace
