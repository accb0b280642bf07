// Whoever makes a GL object shows that a context is current on this thread.
#include "renderer/gl/gl.hpp"

furnace::gl::VertexArray make(furnace::gl::Context& context) {
#ifdef FORBIDDEN
  return furnace::gl::create_vertex_array();
#else
  return furnace::gl::create_vertex_array(context);
#endif
}
