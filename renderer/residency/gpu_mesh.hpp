// A mesh on the GPU: one buffer of attribute arrays, one of indices.
#pragma once

#include "renderer/gl/gl.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Threads: the context's. Owns: its buffers.
struct GpuMesh {
  gl::Buffer vertices, indices;
  gl::VertexArray vertex_array;
  GLenum mode = GL_TRIANGLES;
  GLsizei index_count = 0;
  Bounds bounds;
  std::size_t bytes = 0;
};

// Absent attributes read as glTF's neutral values: colour 1, everything else 0.
GpuMesh upload_mesh(gl::Context& context, const Mesh& mesh);

}  // namespace furnace
