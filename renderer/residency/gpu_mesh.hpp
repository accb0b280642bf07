// A mesh on the GPU: one buffer of interleaved vertices, one of indices; both are read by the rasteriser and, as textures, by
// deferred shading.
#pragma once

#include "renderer/gl/gl.hpp"
#include "renderer/residency/packed_mesh.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Threads: the context's. Owns: its buffers.
struct GpuMesh {
  gl::Buffer vertices, indices;
  gl::Texture
      vertex_texels;  // rows of four floats: position, normal, tangent, both UV sets, and colour where there is one
  gl::Texture index_texels;
  gl::VertexArray vertex_array;
  GLenum mode = GL_TRIANGLES;
  GLsizei index_count = 0;
  std::uint32_t vertex_rows = 0;  // rows a vertex
  Bounds bounds;
  std::size_t bytes = 0;
};

// `packed`: of this mesh. An absent colour reads as 1.
// Errors: kTooLarge when it has more vertices than the GPU can read.
GpuMesh upload_mesh(gl::Context& context, const Mesh& mesh, const PackedMesh& packed);

}  // namespace furnace
