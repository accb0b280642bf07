#include "renderer/residency/gpu_mesh.hpp"

#include <cstring>

namespace furnace {
namespace {

struct AttributeArray {
  GLuint location;
  GLint components;
  const void* data;
  std::size_t count;
  std::size_t stride;
};

template <class T>
AttributeArray array_of(GLuint location, GLint components, const std::vector<T>& values) {
  return {location, components, values.data(), values.size(), sizeof(T)};
}

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

}  // namespace

GpuMesh upload_mesh(gl::Context& context, const Mesh& mesh) {
  // Locations of surface.vert.
  const AttributeArray arrays[] = {array_of(0, 3, mesh.positions), array_of(1, 3, mesh.normals),
                                   array_of(2, 4, mesh.tangents),  array_of(3, 2, mesh.uvs[0]),
                                   array_of(4, 2, mesh.uvs[1]),    array_of(5, 4, mesh.colors)};
  std::size_t bytes = 0;
  for (const AttributeArray& array : arrays) bytes += array.count * array.stride;
  std::vector<std::byte> packed(bytes);

  GpuMesh gpu;
  gpu.vertex_array = gl::create_vertex_array(context);
  const GLuint vao = gpu.vertex_array.id();
  std::size_t offset = 0;
  for (const AttributeArray& array : arrays) {
    if (array.count == 0) continue;
    std::memcpy(packed.data() + offset, array.data, array.count * array.stride);
    glEnableVertexArrayAttrib(vao, array.location);
    glVertexArrayAttribFormat(vao, array.location, array.components, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vao, array.location, array.location);
    offset += array.count * array.stride;
  }
  gpu.vertices = gl::create_buffer(context, packed.data(), packed.size());
  gpu.indices = gl::create_buffer(context, mesh.indices.data(), mesh.indices.size() * sizeof(std::uint32_t));
  offset = 0;
  for (const AttributeArray& array : arrays) {
    if (array.count == 0) continue;
    glVertexArrayVertexBuffer(vao, array.location, gpu.vertices.id(), GLintptr(offset),
                              GLsizei(array.stride));
    offset += array.count * array.stride;
  }
  glVertexArrayElementBuffer(vao, gpu.indices.id());
  gpu.mode = primitive_mode(mesh.topology);
  gpu.index_count = GLsizei(mesh.indices.size());
  gpu.bounds = mesh.bounds;
  gpu.bytes = bytes + mesh.indices.size() * sizeof(std::uint32_t);
  return gpu;
}

}  // namespace furnace
