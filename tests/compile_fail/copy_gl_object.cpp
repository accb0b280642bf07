// A GL object has one owner: it moves, it is never copied.
#include <utility>

#include "renderer/gl/gl.hpp"

furnace::gl::Buffer owner();

furnace::gl::Buffer hand_over() {
  furnace::gl::Buffer buffer = owner();
#ifdef FORBIDDEN
  furnace::gl::Buffer second = buffer;
#else
  furnace::gl::Buffer second = std::move(buffer);
#endif
  return second;
}
