// The "v" statements of an OBJ file: x y z, then a weight w, or a colour, or a colour and its alpha.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

namespace furnace {

struct ObjVertex {
  glm::vec3 position{0};           // over its weight
  std::optional<glm::vec3> color;  // as written: to 1, or to 255
};

// Of what follows the "v" of the vertex with this number. Errors: kUnprocessable, not 3, 4, 6 or 7 numbers.
ObjVertex obj_vertex(std::string_view statement, std::size_t number);

// The document with as many numbers in each vertex and nothing else; none if it is so. The library counts vertices and
// colours apart, so that one without a colour gives its place to the next one's, leaves out vertices with an alpha, and
// counts numbers in comments (assimp 5.2.5). Errors: as obj_vertex.
std::optional<std::string> with_even_vertices(std::string_view obj);

}  // namespace furnace
